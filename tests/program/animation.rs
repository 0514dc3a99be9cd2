//! Animations of models by themselves.

use crate::common::{Folder, MOVING_MODEL};

const SMALL: [&str; 7] = ["a.gltf", "--resolution", "16x12", "--samples", "2", "-o", "f.##.exr"];

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("a.gltf", MOVING_MODEL);
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
    let text = folder.succeed(&["check", "a.gltf", "--animation", "Run"]);
    assert!(
        text.contains("13 frames to render") && text.contains("animation Run: 0.5 s, moves 1 node, is played\n"),
        "{text}"
    );
    let unknown = folder.fail(2, &["check", "a.gltf", "--animation", "Rum"]);
    assert!(
        unknown.contains("unknown animation `Rum` (did you mean `Run`?)"),
        "{unknown}"
    );
    let output = folder.run(&["check", "a.gltf"]);
    let warning = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        warning.contains("2 animations (the rest pose is shown): `Walk`, `Run`"),
        "{warning}"
    );
}
