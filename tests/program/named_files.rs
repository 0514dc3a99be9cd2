//! Files that tables of values and draws name: what is checked of them, and when.

use std::fs;

use crate::common::{Folder, MOVING_MODEL, SMALL_SCENE, stderr};

/// A file whose header says that it is longer than it is.
fn cut_off() -> Vec<u8> {
    [&b"glTF"[..], &2_u32.to_le_bytes(), &4000_u32.to_le_bytes(), &[0; 40]].concat()
}

/// A scene whose walker shows a good model, and files that draw and name a broken one.
fn folder() -> Folder {
    let folder = Folder::new();
    let walker = "[[object]]\nname = \"walker\"\nshape.mesh = { file = \"a.gltf\" }\n";
    folder.write("s.toml", &format!("{SMALL_SCENE}\n{walker}"));
    folder.write("a.gltf", MOVING_MODEL);
    fs::write(folder.path("b.glb"), cut_off()).expect("written");
    folder.write(
        "r.toml",
        "\n\"object.walker.shape.mesh.file\" = [\"a.gltf\", \"b.glb\"]\n",
    );
    folder.write(
        "v.csv",
        "frame,object.walker.shape.mesh.file\n1,a.gltf\n2,a.gltf\n3,b.glb\n",
    );
    folder
}

const OF_DRAWS: [&str; 3] = ["s.toml", "--random", "r.toml"];
const OF_CELLS: [&str; 3] = ["s.toml", "--values", "v.csv"];

/// The message of each way to check a job.
fn refused(folder: &Folder, code: i32, args: &[&str]) -> [String; 3] {
    let output = ["-o", "f.####.png", "--range", "1"];
    [
        folder.fail(code, &[&["check"], args].concat()),
        folder.fail(code, &[args, &output, &["--check"]].concat()),
        folder.fail(code, &[args, &output, &["--dry-run"]].concat()),
    ]
}

#[test]
fn a_check_loads_each_model_that_a_draw_or_a_cell_may_show() {
    let folder = folder();
    for (args, place) in [(OF_DRAWS, "r.toml:2: "), (OF_CELLS, "v.csv:4: ")] {
        let place = format!("{place}object.walker.shape.mesh.file: ");
        for message in refused(&folder, 65, &args) {
            assert!(message.contains(&place) && message.contains("b.glb"), "{message}");
            assert!(!message.contains("draws"), "{message}");
        }
    }
    // Frames that show other files are rendered.
    folder.succeed(&[&OF_CELLS[..], &["--range", "1-2", "-o", "f.####.png"]].concat());
    folder.write(
        "r.toml",
        "\"object.walker.shape.mesh.file\" = [\"a.gltf\", \"none.glb\"]\n",
    );
    let all = [&OF_DRAWS[..], &["-o", "f.####.png"]].concat();
    for message in [&refused(&folder, 66, &OF_DRAWS)[..], &[folder.fail(66, &all)]].concat() {
        assert!(
            message.contains("r.toml:1: object.walker.shape.mesh.file: cannot read the file: "),
            "{message}"
        );
    }
    fs::copy(folder.path("a.gltf"), folder.path("c.gltf")).expect("copied");
    folder.write(
        "r.toml",
        "\"object.walker.shape.mesh.file\" = [\"a.gltf\", \"c.gltf\"]\n",
    );
    folder.succeed(&[&["check"], &OF_DRAWS[..]].concat());
}

#[test]
fn images_of_models_that_may_be_drawn_are_checked_as_those_of_the_scene() {
    let folder = folder();
    let textured = MOVING_MODEL
        .replace(r#""POSITION": 0}"#, r#""POSITION": 0}, "material": 0"#)
        .replace(
            r#""meshes""#,
            r#""images": [{"uri": "wood.png"}], "textures": [{"source": 0}], "materials": [{"pbrMetallicRoughness":
                {"baseColorTexture": {"index": 0}}}], "meshes""#,
        );
    folder.write("b.gltf", &textured);
    folder.write(
        "r.toml",
        "\"object.walker.shape.mesh.file\" = [\"a.gltf\", \"b.gltf\"]\n",
    );
    for message in refused(&folder, 66, &OF_DRAWS) {
        let place = "r.toml:1: object.walker.shape.mesh.file: cannot read image: ";
        assert!(message.contains(place) && message.contains("wood.png"), "{message}");
    }
    folder.write("wood.png", "no picture");
    refused(&folder, 65, &OF_DRAWS);
    let placeholders = ["--missing-assets", "placeholder"];
    let output = folder.run(&[&["check"], &OF_DRAWS[..], &placeholders].concat());
    assert!(output.status.success());
    assert!(
        stderr(&output).contains("a placeholder is shown: "),
        "{}",
        stderr(&output)
    );
    // A material of the scene takes the place of those of the model.
    folder.write(
        "r.toml",
        "\"object.walker.shape.mesh.file\" = [\"a.gltf\", \"b.gltf\"]\n\"object.walker.material\" = [\"red\"]\n",
    );
    folder.succeed(&[&["check"], &OF_DRAWS[..]].concat());
}

#[test]
fn images_of_variants_that_may_be_drawn_are_checked_as_well() {
    let folder = folder();
    let variants = r#""extensionsUsed": ["KHR_materials_variants"],
        "extensions": {"KHR_materials_variants": {"variants": [{"name": "Plain"}, {"name": "Wood"}]}},
        "images": [{"uri": "wood.png"}], "textures": [{"source": 0}],
        "materials": [{"name": "plain"}, {"name": "wood", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], "meshes""#;
    let mappings = r#""POSITION": 0}, "extensions": {"KHR_materials_variants": {"mappings": [
        {"material": 0, "variants": [0]}, {"material": 1, "variants": [1]}]}}"#;
    let model = MOVING_MODEL
        .replace(r#""POSITION": 0}"#, mappings)
        .replace(r#""meshes""#, variants);
    folder.write("a.gltf", &model);
    folder.write("v.csv", "frame,object.walker.shape.mesh.variant\n1,Plain\n2,Wood\n");
    for message in refused(&folder, 66, &OF_CELLS) {
        assert!(
            message.contains("v.csv:3: object.walker.shape.mesh.variant: cannot read image")
                && message.contains("wood.png"),
            "{message}"
        );
    }
    let output = folder.run(&[&OF_CELLS[..], &["--range", "1", "-o", "f.####.png"]].concat());
    let said = stderr(&output);
    assert!(
        output.status.success() && !said.contains("there are material variants"),
        "{said}"
    );
}

#[test]
fn pictures_and_profiles_that_cells_name_are_loaded_as_well() {
    let folder = folder();
    folder.write("wood.png", "no picture");
    folder.write("lamp.ies", "no lamp");
    image::RgbImage::new(2, 2)
        .save(folder.path("sign.png"))
        .expect("written");
    let scene = String::from_utf8(folder.read("s.toml")).expect("UTF-8");
    let light = "[[light]]\nname = \"lamp\"\npoint = { position = [0, 4, 0], intensity = 9 }\n";
    let sign = "[texture.sign]\nimage = { file = \"sign.png\" }\n";
    folder.write("s.toml", &format!("{scene}{light}{sign}"));
    folder.write("v.csv", "frame,light.lamp.point.ies\n1,lamp.ies\n");
    let messages = refused(&folder, 65, &OF_CELLS);
    assert!(
        messages.iter().all(|message| message.contains("lamp.ies")),
        "{messages:?}"
    );
    folder.write("v.csv", "frame,texture.sign.image.file\n1,wood.png\n");
    let messages = refused(&folder, 65, &OF_CELLS);
    assert!(
        messages.iter().all(|message| message.contains("wood.png")),
        "{messages:?}"
    );
}

#[test]
fn animations_that_values_choose_are_not_said_to_be_missing() {
    let folder = folder();
    folder.write("v.csv", "frame,object.walker.shape.mesh.animation\n1,Walk\n2,Run\n");
    let draw = "random.object.a.shape.mesh.animation=[\"Walk\",\"Run\"]";
    let size = [
        "--resolution",
        "8x6",
        "--samples",
        "1",
        "-o",
        "f.####.png",
        "--progress",
        "none",
    ];
    for (args, is_missing) in [
        (&OF_CELLS[..], false),
        (&["a.gltf", "--set", draw], false),
        (&["a.gltf"], true),
        (&["s.toml"], true),
    ] {
        let output = folder.run(&[args, &size].concat());
        let said = stderr(&output);
        assert!(output.status.success(), "{said}");
        assert_eq!(
            said.contains("not rendered: 2 animations"),
            is_missing,
            "{args:?}: {said}"
        );
    }
}

#[test]
fn flags_that_draw_what_is_not_there_are_wrong_usage_and_files_are_wrong_data() {
    let folder = folder();
    let output = ["-o", "f.####.png"];
    for draw in [
        "light.kay.point.intensity=[1,2]",
        "object.walker.visible=[1,2]",
        "object.walker.material=[\"x\",\"y\"]",
    ] {
        let flag = format!("random.{draw}");
        folder.fail(2, &[&["s.toml", "--set", &flag], &output[..]].concat());
        folder.write("r.toml", &draw.replacen('=', " = ", 1));
        folder.fail(65, &[&OF_DRAWS[..], &output].concat());
        folder.fail(
            2,
            &[&["a.gltf", "--set", &flag.replace("walker", "a")], &output[..]].concat(),
        );
    }
}
