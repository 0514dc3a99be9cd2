//! Animations of models by themselves.

use crate::common::Folder;

/// A triangle that two animations move, each over half a second.
const MODEL: &str = r#"{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 68, "uri":
    "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAA="}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
    {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
    {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [0.5]},
    {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}],
    "animations": [{"name": "Walk", "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
    "samplers": [{"input": 1, "output": 2}]},
    {"name": "Run", "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
    "samplers": [{"input": 1, "output": 2}]}]}"#;

const SMALL: [&str; 7] = ["a.gltf", "--resolution", "16x12", "--samples", "2", "-o", "f.##.exr"];

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("a.gltf", MODEL);
    folder
}

#[test]
fn a_model_by_itself_renders_one_run_and_chunks_have_the_bytes_of_the_whole() {
    let folder = folder();
    let run = |args: &[&str]| folder.succeed(&[&SMALL[..], &["--animation", "Walk"], args].concat());
    run(&[]);
    let files: Vec<String> = folder
        .names()
        .into_iter()
        .filter(|name| name.ends_with(".exr"))
        .collect();
    // Half a second at 24 frames each.
    assert_eq!(
        (files.len(), &files[0][..], &files[12][..]),
        (13, "f.00.exr", "f.12.exr")
    );
    let whole: Vec<Vec<u8>> = files.iter().map(|file| folder.read(file)).collect();
    assert!(whole[0] != whole[6] && whole[6] != whole[12]);
    run(&["--range", "3-5"]);
    run(&["--range", "12,40"]);
    let again: Vec<Vec<u8>> = files.iter().map(|file| folder.read(file)).collect();
    assert!(whole == again);
    let text = run(&["--list-stale"]);
    assert!(!text.contains("f.03"), "{text}");
}

#[test]
fn names_that_do_not_fit_are_wrong_usage() {
    let folder = folder();
    let fail = |name: &str| folder.fail(2, &[&SMALL[..], &["--animation", name]].concat());
    let unknown = fail("Wolk");
    assert!(
        unknown.contains("unknown animation `Wolk` (did you mean `Walk`?)"),
        "{unknown}"
    );
    let both = fail("all");
    assert!(
        both.contains("the animations `Walk` and `Run` both move the translation of node 0"),
        "{both}"
    );
    let scene = "[camera]\nperspective = { eye = [0, 0, 5], target = [0, 0, 0] }\n";
    folder.write("s.toml", scene);
    let own = folder.fail(2, &["s.toml", "--animation", "Walk"]);
    assert!(own.contains("--animation plays those of a model"), "{own}");
}

#[test]
fn check_lists_animations_and_a_model_at_rest_says_what_it_does_not_play() {
    let folder = folder();
    let text = folder.succeed(&["check", "a.gltf"]);
    assert!(text.contains("animation Walk: 0.5 s, moves 1 node\n"), "{text}");
    let output = folder.run(&["check", "a.gltf"]);
    let warning = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        warning.contains("2 animations (the rest pose is shown): `Walk`, `Run`"),
        "{warning}"
    );
}
