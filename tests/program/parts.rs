//! Values of the nodes and materials of a model.

use crate::common::Folder;
use batch_render::{
    batch::{Job, Request},
    describe::Overrides,
    render::Control,
};

/// A triangle at several nodes: two of one name, one with a point in its name, one below another, and one with two copies.
pub const MODEL: &str = r#"{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 68, "uri":
    "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAA="}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
    {"bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3"}],
    "extensionsUsed": ["EXT_mesh_gpu_instancing", "KHR_node_visibility"],
    "materials": [{"name": "Paint", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.2, 0.1, 1]}},
    {"name": "Glow", "emissiveFactor": [1, 1, 1]}, {"name": "Paint"}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]},
    {"primitives": [{"attributes": {"POSITION": 0}, "material": 1}]},
    {"primitives": [{"attributes": {"POSITION": 0}, "material": 2}]}],
    "nodes": [{"name": "Wheel", "mesh": 0, "children": [4]}, {"name": "Wheel", "mesh": 2, "translation": [-1.2, 0, 0]},
    {"name": "Wheel.L", "mesh": 0, "translation": [0, -1.2, 0]},
    {"name": "crowd", "mesh": 0, "translation": [-1.2, -1.2, 0], "scale": [0.4, 0.4, 0.4],
    "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}},
    {"mesh": 1, "translation": [0.9, 0.9, 0.2], "scale": [0.3, 0.3, 0.3]},
    {"name": "spare", "mesh": 0, "translation": [0, -1.2, 0.5], "extensions": {"KHR_node_visibility": {"visible": false}}}]}"#;

/// The head of a scene whose camera looks at the model from the front.
pub const HEAD: &str = r#"
[render]
width = 32
height = 32
samples = 4
[camera]
orthographic = { eye = [0, 0, 5], target = [0, 0, 0], height = 4 }
[background]
color = 0.3
"#;

const CAR: &str = r#"
[[object]]
name = "car"
shape.mesh = { file = "car.gltf" }
[[light]]
point = { position = [0, 0, 5], intensity = 20 }
"#;

const TABLE: &str = "frame,interp,object.car.node.Wheel.L.transform.translate.x,object.car.node.Wheel.transform.rotate.z,\
                     object.car.material.Paint.base_color.g,object.car.material.Paint#2.base_color.b\n\
                     1,linear,0,0,0.2,0.2\n4,linear,0.9,40,0.8,0.2\n6,linear,0.9,40,0.8,0.9\n";

const JOB: [&str; 6] = ["s.toml", "-o", "f.##.exr", "--skip-existing", "--exr-type", "float"];

fn folder(table: &str) -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", &format!("values = \"v.csv\"\n{HEAD}{CAR}"));
    folder.write("v.csv", table);
    folder.write("car.gltf", MODEL);
    folder
}

fn frames(folder: &Folder) -> Vec<(String, Vec<u8>)> {
    let names = folder.names().into_iter().filter(|name| name.ends_with(".exr"));
    names.map(|name| (name.clone(), folder.read(&name))).collect()
}

#[test]
fn frames_with_parts_of_a_model_have_the_same_bytes_alone_in_parts_and_in_sequence() {
    let whole = folder(TABLE);
    whole.succeed(&JOB);
    let other = folder(TABLE);
    for args in [
        &["--range", "5", "--threads", "1"][..],
        &["--range", "1-3x2"],
        &["--part", "2/2", "--threads", "3"],
        &[],
    ] {
        other.succeed(&[&JOB[..], args].concat());
    }
    let (whole, other) = (frames(&whole), frames(&other));
    assert!(whole == other && whole.len() == 6);
    assert!(whole[0].1 != whole[1].1 && whole[3].1 != whole[5].1);
}

#[test]
fn a_crop_with_parts_of_a_model_has_the_pixels_of_the_whole() {
    let folder = folder(TABLE);
    folder.succeed(&["s.toml", "-o", "f.##.exr", "--range", "3"]);
    let (width, whole) = crate::common::pixels(&folder.path("f.03.exr"));
    folder.succeed(&["s.toml", "-o", "c.##.exr", "--range", "3", "--crop", "8,8,24,24"]);
    let (_, crop) = crate::common::pixels(&folder.path("c.03.exr"));
    let rows = (8..24).flat_map(|y| &whole[y * width + 8..y * width + 24]);
    assert!(rows.eq(&crop) || whole == crop);
}

#[test]
fn a_changed_row_of_a_part_concerns_its_own_frames() {
    let folder = folder(TABLE);
    folder.succeed(&JOB);
    let stale = || {
        let said = folder.succeed(&[&["s.toml", "--list-stale"], &JOB[1..3], &JOB[4..]].concat());
        let first = |line: &str| line.split('\t').next().unwrap_or_default().to_owned();
        said.lines().map(first).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(stale(), "");
    folder.write(
        "v.csv",
        &TABLE.replace("6,linear,0.9,40,0.8,0.9", "6,linear,0.9,40,0.8,0.7"),
    );
    assert_eq!(stale(), "5 6");
}

#[test]
fn a_flag_sets_what_a_table_sets() {
    let folder = folder(TABLE);
    folder.write("s.toml", &format!("{HEAD}{CAR}"));
    let render = |name: &str, args: &[&str]| {
        let file = format!("{name}.exr");
        folder.succeed(&[&["s.toml", "-o", &file, "--samples", "4"], args].concat());
        crate::common::pixels(&folder.path(&file)).1
    };
    let plain = render("plain", &[]);
    for values in [
        &["object.car.node.Wheel.visible=false"][..],
        &["object.car.node.Wheel#2.transform.translate.x=-0.8"],
        &["object.car.node.4.visible=false"],
        &["object.car.node.crowd.transform.scale=1.5"],
        &["object.car.node.spare.visible=true"],
        &["object.car.material.Paint={base_color=[0,1,0]}"],
        &[
            "object.car.material.Paint#2.roughness=0.1",
            "object.car.material.Glow.emissive.r=0",
        ],
    ] {
        let set: Vec<&str> = values.iter().flat_map(|value| ["--set", value]).collect();
        let by_flag = render("set", &set);
        assert!(by_flag != plain, "{values:?}");
        if values[0].contains('{') {
            continue;
        }
        let (names, cells): (Vec<&str>, Vec<&str>) = values.iter().filter_map(|value| value.split_once('=')).unzip();
        folder.write("t.csv", &format!("frame,{}\n1,{}\n", names.join(","), cells.join(",")));
        assert!(by_flag == render("table", &["--values", "t.csv"]), "{values:?}");
    }
    // The child of an invisible node is invisible, too.
    let both = [
        "--set",
        "object.car.node.Wheel.visible=false",
        "--set",
        "object.car.node.4.visible=true",
    ];
    assert!(render("both", &both) == render("one", &both[..2]));
}

#[test]
fn parts_of_an_object_are_no_objects_of_their_own() {
    let folder = folder(TABLE);
    let parts = "[[object.part]]\nnodes = [\"Wheel*\"]\n[[object.part]]\nnodes = [\"crowd\"]\nholdout = true\n";
    folder.write(
        "s.toml",
        &format!("{HEAD}{}", CAR.replace("[[light]]", &format!("{parts}[[light]]"))),
    );
    let said = folder.succeed(&["check", "s.toml"]);
    assert!(said.contains("\n1 object: "), "{said}");
}

#[test]
fn a_material_of_the_scene_takes_the_place_of_one_of_the_model() {
    let folder = folder(TABLE);
    let scene = format!("{HEAD}{CAR}[material.steel]\nmatte = {{ albedo = [0, 0, 1] }}\n");
    folder.write("s.toml", &scene);
    let render = |name: &str, args: &[&str]| {
        let file = format!("{name}.exr");
        folder.succeed(&[&["s.toml", "-o", &file, "--aovs", "materialId"], args].concat());
        crate::common::pixels(&folder.path(&file)).1
    };
    let plain = render("plain", &[]);
    let by_flag = render("set", &["--set", "object.car.material.Paint=steel"]);
    assert!(by_flag != plain);
    folder.write("t.csv", "frame,object.car.material.Paint\n1,steel\n");
    assert!(by_flag == render("table", &["--values", "t.csv"]));
    let keys = "[object.material_overrides]\nPaint = \"steel\"\n[[light]]";
    folder.write("s.toml", &scene.replace("[[light]]", keys));
    assert!(by_flag == render("file", &[]));
    // The other `Paint` keeps its own.
    assert!(by_flag != render("both", &["--set", "object.car.material.Paint#2=steel"]));
    let message = folder.fail(2, &["s.toml", "--set", "object.car.material.Paint=stel"]);
    assert!(
        message.contains("undefined material `stel`") || message.contains("unknown material `stel`"),
        "{message}"
    );
}

#[test]
fn names_of_parts_that_are_unknown_are_wrong_usage_of_a_flag_and_wrong_data_of_a_file() {
    let folder = folder(TABLE);
    folder.write("s.toml", &format!("{HEAD}{CAR}"));
    let set = |value: &str| folder.fail(2, &["s.toml", "--set", value]);
    let message = set("object.car.node.Whel.visible=false");
    let expected = "--set object.car.node.Whel.visible: unknown node `Whel` (did you mean `Wheel`?)";
    assert!(message.contains(expected), "{message}");
    let message = set("object.car.material.Pant.roughness=0.5");
    assert!(
        message.contains("unknown material `Pant` (did you mean `Paint`?)"),
        "{message}"
    );
    let message = set("object.car.material.Paint.metalic=0.5");
    assert!(
        message.contains("unknown key `metalic` (did you mean `metallic`?)"),
        "{message}"
    );
    let message = set("object.car.node.Wheel.transform.rotate.qx=1");
    assert!(message.contains("missing field `qy`"), "{message}");
    folder.write("t.csv", "frame,object.car.node.Wheel.R.visible\n1,0\n");
    let message = folder.fail(65, &["s.toml", "--values", "t.csv"]);
    let expected = "t.csv:1: object.car.node.Wheel.R.visible: unknown node `Wheel.R` (did you mean `Wheel.L`?)";
    assert!(message.contains(expected), "{message}");
}

#[test]
fn objects_and_materials_of_obj_files_have_names_too() {
    let folder = folder(TABLE);
    folder.write("s.toml", &format!("{HEAD}{CAR}").replace("car.gltf", "car.obj"));
    folder.write("car.mtl", "newmtl red\nKd 0.8 0.1 0.1\nnewmtl blue\nKd 0.1 0.1 0.8\n");
    let triangle = |x: f32| format!("v {x} 0 0\nv {} 0 0\nv {x} 1 0\n", x + 1.0);
    let text = format!(
        "mtllib car.mtl\n{}{}o left\nusemtl red\nf 1 2 3\no right\nusemtl blue\nf 4 5 6\n",
        triangle(-1.5),
        triangle(0.5)
    );
    folder.write("car.obj", &text);
    let render = |name: &str, args: &[&str]| {
        let file = format!("{name}.exr");
        folder.succeed(&[&["s.toml", "-o", &file], args].concat());
        crate::common::pixels(&folder.path(&file)).1
    };
    let plain = render("plain", &[]);
    for value in [
        "object.car.material.red.base_color=[0,1,0]",
        "object.car.node.left.visible=false",
        "object.car.node.right.transform.translate.y=0.5",
    ] {
        assert!(render("set", &["--set", value]) != plain, "{value}");
    }
    // The colour of the MTL file itself.
    let same = render("same", &["--set", "object.car.material.red.base_color=[0.8, 0.1, 0.1]"]);
    assert!(same == plain);
    let message = folder.fail(2, &["s.toml", "--set", "object.car.node.middle.visible=false"]);
    assert!(message.contains("unknown node `middle`"), "{message}");
}

/// The film of a frame of a table in a job with these passes, in which the camera's shutter is as given.
fn film(table: &str, shutter: &str, number: i32) -> batch_render::film::Film {
    let folder = folder(table);
    let request = Request {
        overrides: Overrides::default()
            .with("output.aovs", vec!["forward", "P"])
            .with("camera.shutter", shutter.parse::<toml::Value>().expect("a list")),
        ..Request::default()
    };
    let job = Job::open(&folder.path("s.toml"), &request).unwrap_or_else(|e| panic!("{e}"));
    let mut scenes = job.scenes(job.compile().unwrap_or_else(|e| panic!("{e}")));
    let index = job.plan.frames.iter().position(|frame| frame.number == number);
    job.render_frame(&mut scenes, index.expect("a frame"), &Control::default())
        .unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn motion_vectors_follow_a_node_of_a_table() {
    // Eight pixels a metre, and a tenth of one a frame.
    let table = "frame,interp,object.car.node.Wheel.transform.translate.x,object.car.node.Wheel#2.visible,\
                 object.car.node.Wheel.L.visible,object.car.node.crowd.visible\n1,linear,0,0,0,0\n5,linear,0.4,0,0,0\n";
    let film = film(table, "[0, 0]", 3);
    let plane = |name: &str| film.plane(name).expect("a pass").values.chunks_exact(3);
    let vectors = plane("forward").zip(plane("P")).filter(|(_, p)| **p != [0.0; 3]);
    let mut count = 0;
    for (vector, _) in vectors {
        assert!((vector[0] - 0.8).abs() < 1e-3 && vector[1].abs() < 1e-3, "{vector:?}");
        count += 1;
    }
    assert!(count > 20, "{count}");
}

#[test]
fn a_node_that_moves_within_the_shutter_is_blurred() {
    let table = "frame,interp,object.car.node.Wheel.transform.translate.x\n1,linear,-1\n5,linear,1\n";
    let [sharp, blurred] = ["[0, 0]", "[0, 1]"].map(|shutter| film(table, shutter, 2));
    assert!(sharp.beauty() != blurred.beauty());
    // A node that rests is not.
    let table = table.replace(",1\n", ",-1\n");
    let [sharp, open] = ["[0, 0]", "[0, 1]"].map(|shutter| film(&table, shutter, 2));
    assert!(sharp.beauty() == open.beauty());
}

#[test]
fn cryptomatte_layers_have_the_same_names_whether_a_node_is_visible_or_not() {
    let folder = folder("frame,object.car.node.Wheel.visible\n1,1\n2,0\n");
    folder.succeed(&["s.toml", "-o", "f.##.exr", "--aovs", "CryptoObject"]);
    let manifest = |frame: u32| {
        let text = String::from_utf8_lossy(&folder.read(&format!("f.{frame:02}.exr"))).into_owned();
        let start = text.find("manifest").expect("a manifest");
        let from = start + text[start..].find('{').expect("it begins");
        text[from..].split('}').next().unwrap_or_default().to_owned()
    };
    assert_eq!(manifest(1), manifest(2));
    assert!(manifest(1).contains("Wheel.L"), "{}", manifest(1));
}
