//! Values of a model by itself.

use crate::{
    common::{Folder, pixels},
    parts::MODEL,
};

const SMALL: [&str; 5] = ["car.gltf", "--resolution", "24x16", "--samples", "4"];

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("car.gltf", MODEL);
    folder
}

/// The pixels of frame 1 with these arguments.
fn picture(folder: &Folder, args: &[&str]) -> Vec<[f32; 3]> {
    folder.succeed(&[&SMALL[..], &["-o", "p.exr", "--range", "1"], args].concat());
    pixels(&folder.path("p.exr")).1
}

#[test]
fn a_table_moves_a_model_by_itself_and_chunks_have_the_bytes_of_the_whole() {
    let folder = folder();
    let table = "frame,interp,node.Wheel.L.transform.translate.x,material.Paint.base_color.g,object.car.transform.rotate.y,\
                 light.light 1.sun.irradiance,camera.perspective.fov\n1,linear,0,0.2,0,2.2,35\n5,linear,2,0.9,30,1,60\n";
    folder.write("v.csv", table);
    let run = |args: &[&str]| folder.succeed(&[&SMALL[..], &["-o", "f.##.exr", "--values", "v.csv"], args].concat());
    run(&[]);
    let files: Vec<String> = (1..=5).map(|frame| format!("f.{frame:02}.exr")).collect();
    let whole: Vec<Vec<u8>> = files.iter().map(|file| folder.read(file)).collect();
    assert!(whole.windows(2).all(|pair| pair[0] != pair[1]));
    run(&["--range", "4"]);
    run(&["--range", "2-3", "--threads", "1"]);
    assert!(files.iter().map(|file| folder.read(file)).eq(whole));
    let text = run(&["--list-stale"]);
    assert!(text.is_empty(), "{text}");
}

#[test]
fn short_names_of_a_model_are_those_of_its_object() {
    let folder = folder();
    let plain = picture(&folder, &[]);
    for (short, whole) in [
        ("node.Wheel.visible=false", "object.car.node.Wheel.visible=false"),
        (
            "material.Paint.base_color=0.1",
            "object.0.material.Paint.base_color=0.1",
        ),
        ("transform.rotate.y=70", "object.car.transform.rotate.y=70"),
    ] {
        let found = picture(&folder, &["--set", short]);
        assert!(found == picture(&folder, &["--set", whole]), "{short}");
        assert!(found != plain, "{short}");
    }
}

#[test]
fn what_is_supplied_with_a_model_has_values_too() {
    let folder = folder();
    let plain = picture(&folder, &[]);
    for value in [
        "light.light 1.sun.irradiance=0.2",
        "light.0.sun.direction=[0, -1, 0]",
        "background.color=[0, 0, 1]",
        "camera.perspective.fov=20",
        "camera.perspective.eye.x=3",
    ] {
        assert!(picture(&folder, &["--set", value]) != plain, "{value}");
    }
    // Another camera takes the place of the supplied one as a whole.
    let other = [
        "orthographic.eye=[0, 0, 9]",
        "orthographic.target=[0, 0, 0]",
        "orthographic.height=3",
    ];
    let other = other.map(|value| format!("camera.{value}"));
    let args: Vec<&str> = other.iter().flat_map(|value| ["--set", value]).collect();
    assert!(picture(&folder, &args) != plain);
}

#[test]
fn a_supplied_camera_frames_what_a_table_moves() {
    let folder = folder();
    // All but one wheel are gone, and that is far away in the last frame.
    let names = ["Wheel#2", "Wheel.L", "crowd", "4"].map(|name| format!("node.{name}.visible"));
    let table = format!(
        "frame,node.Wheel.transform.translate.x,background.color,{}\n1,0,0,0,0,0,0\n9,6,0,0,0,0,0\n",
        names.join(",")
    );
    folder.write("v.csv", &table);
    folder.succeed(&[&SMALL[..], &["-o", "f.##.exr", "--values", "v.csv", "--range", "1,9"]].concat());
    let is_seen = |frame: u32| {
        let (_, pixels) = pixels(&folder.path(&format!("f.{frame:02}.exr")));
        pixels.iter().any(|rgb| rgb[0] > 0.0)
    };
    assert!(is_seen(1) && is_seen(9));
}

#[test]
fn a_camera_follows_the_node_that_a_table_moves() {
    let folder = folder();
    let camera = r#"{"name": "rig", "children": [7]},
        {"name": "eye", "camera": 0, "translation": [0, 0, 4]}]"#;
    let model = MODEL.trim_end_matches('}').trim_end_matches(']').to_owned() + ", " + camera;
    let cameras = r#", "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}]}"#;
    folder.write("car.gltf", &(model + cameras));
    folder.write(
        "v.csv",
        "frame,interp,node.rig.transform.translate.x\n-1,linear,-1\n1,linear,0.5\n3,linear,2\n",
    );
    let plain = picture(&folder, &[]);
    let moved = picture(&folder, &["--values", "v.csv"]);
    assert!(moved == picture(&folder, &["--set", "node.rig.transform.translate.x=0.5"]));
    assert!(moved != plain);
}

#[test]
fn names_that_a_model_does_not_have_are_told_with_the_nearest_ones() {
    let folder = folder();
    let fail = |args: &[&str]| folder.fail(2, &[&SMALL[..], args].concat());
    let message = fail(&["--set", "node.Whel.visible=false"]);
    let expected = "--set node.Whel.visible: unknown node `Whel` (did you mean `Wheel`?)";
    assert!(message.contains(expected), "{message}");
    let message = fail(&["--set", "light.lamp.sun.irradiance=1"]);
    assert!(message.contains("unknown light `lamp`"), "{message}");
    let message = fail(&["--set", "material.Pain.roughness=1"]);
    assert!(
        message.contains("unknown material `Pain` (did you mean `Paint`?)"),
        "{message}"
    );
    folder.write("v.csv", "frame,material.Paint.roughnes\n1,0\n");
    let message = folder.fail(65, &[&SMALL[..], &["--values", "v.csv"]].concat());
    let expected = "v.csv:2: material.Paint.roughnes: unknown key `roughnes` (did you mean `roughness`?)";
    assert!(message.contains(expected), "{message}");
    // Scene files have no short names.
    let scene = "[camera]\nperspective = { eye = [0, 0, 5], target = [0, 0, 0] }\n";
    folder.write("s.toml", scene);
    let message = folder.fail(2, &["s.toml", "--set", "node.Wheel.visible=false"]);
    assert!(message.contains("unknown key `node`"), "{message}");
}
