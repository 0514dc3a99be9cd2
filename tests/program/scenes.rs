//! Several scenes in one command.

use std::fs;

use crate::common::{Folder, SMALL_SCENE};

const SMALL: [&str; 4] = ["--resolution", "16x12", "--samples", "2"];

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("a.toml", SMALL_SCENE);
    folder.write("b.toml", &SMALL_SCENE.replace("scale = 6", "scale = 3"));
    folder
}

#[test]
fn each_scene_has_the_files_that_it_has_by_itself() {
    let folder = folder();
    for scene in ["a", "b"] {
        let [file, out] = [format!("{scene}.toml"), format!("alone/{scene}/####.exr")];
        folder.succeed(&[&[&file[..], "--views", "cube", "-o", &out], &SMALL[..]].concat());
    }
    let said = folder.succeed(
        &[
            &["a.toml", "b.toml", "--views", "cube", "-o", "out/{scene}/####.exr"],
            &SMALL[..],
        ]
        .concat(),
    );
    for line in ["scene 1 of 2: a.toml", "scene 2 of 2: b.toml"] {
        assert!(said.lines().any(|other| other == line), "{said}");
    }
    for scene in ["a", "b"] {
        for view in 1..=6 {
            let read = |root: &str| folder.read(&format!("{root}/{scene}/{view:04}.exr"));
            assert!(read("alone") == read("out"), "{scene} {view}");
        }
    }
    assert!(folder.read("out/a/0001.exr") != folder.read("out/b/0001.exr"));
}

#[test]
fn a_scene_that_fails_is_told_and_the_others_are_rendered() {
    let folder = folder();
    folder.write("broken.toml", "[camera");
    let scenes = ["a.toml", "broken.toml", "none.glb", "b.toml"];
    let job = [&scenes[..], &["-o", "{scene}.exr"], &SMALL[..]].concat();
    let said = folder.fail(1, &job);
    assert!(
        said.ends_with("error: 2 of 4 scenes failed: broken.toml, none.glb\n"),
        "{said}"
    );
    assert!(said.contains("--> broken.toml") && said.contains("none.glb"), "{said}");
    assert!(folder.path("a.exr").exists() && folder.path("b.exr").exists());

    fs::remove_file(folder.path("b.exr")).expect("removed");
    folder.fail(65, &[&job[..], &["--fail-fast"]].concat());
    assert!(!folder.path("b.exr").exists());

    // The next run does what is left.
    let modified = |name: &str| {
        fs::metadata(folder.path(name))
            .and_then(|m| m.modified())
            .expect("a file")
    };
    let before = modified("a.exr");
    folder.fail(1, &[&job[..], &["--skip-existing"]].concat());
    assert_eq!(modified("a.exr"), before);
    assert!(folder.path("b.exr").exists());
}

#[test]
fn files_of_two_scenes_are_told_apart_or_refused() {
    let folder = folder();
    let wrong = |more: &[&str], expected: &str| {
        let said = folder.fail(2, &[&["a.toml", "b.toml"], more].concat());
        assert!(said.contains(expected), "{said}");
    };
    wrong(
        &["-o", "f.####.exr"],
        "several scenes would write f.####.exr: tell their files apart by {scene}",
    );
    wrong(&["-o", "{scene}.exr", "--stats", "s.json"], "would write s.json");
    wrong(&["-o", "{scene}.exr", "--metadata", "ids"], "would write ids.json");
    wrong(&["-o", "{scene}.exr", "--png-depth"], "would write depth.####.png");
    wrong(
        &["-o", "-", "--output-format", "png"],
        "standard output holds the frames of one scene",
    );
    wrong(&["-"], "standard input (-) is one scene");
    let said = folder.fail(2, &["a.toml", "./a.toml", "-o", "{scene}.exr"]);
    assert!(said.contains("two scenes have the name of ./a.toml"), "{said}");
    // One scene has a name, too; without -o files have the names of their scenes.
    folder.succeed(&[&["a.toml", "-o", "{scene}/{scene}.png"], &SMALL[..]].concat());
    folder.succeed(&[&["a.toml", "b.toml"], &SMALL[..]].concat());
    for name in ["a/a.png", "a.0001.exr", "b.0001.png"] {
        assert!(folder.path(name).exists(), "{name}: {:?}", folder.names());
    }
}
