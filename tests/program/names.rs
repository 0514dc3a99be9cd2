//! Names of scenes and eyes in the names of files, and files that two of them would share.

use std::fs;

use crate::common::{Folder, SMALL_SCENE};

const SMALL: [&str; 4] = ["--resolution", "16x12", "--samples", "2"];

/// The scene with these files of its own.
fn with_files(files: &str) -> String {
    format!("{SMALL_SCENE}\n[output]\nfiles = {files}\n")
}

fn render(folder: &Folder, args: &[&str]) -> String {
    folder.succeed(&[args, &SMALL[..]].concat())
}

#[test]
fn names_of_scenes_are_literal_whatever_characters_they_have() {
    let folder = Folder::new();
    let names = ["car1", "car#", "car#2", "car$F2", "a%03db", "50%%x", "{eye}", "{scene}"];
    let scenes = names.map(|name| format!("{name}.toml"));
    for scene in &scenes {
        folder.write(scene, SMALL_SCENE);
    }
    let scenes: Vec<&str> = scenes.iter().map(String::as_str).collect();
    let job = [&scenes[..], &["--png-depth={scene}.depth.#.png", "--metadata", "ids"]].concat();
    render(
        &folder,
        &[
            &job[..],
            &["-o", "o/{scene}/{scene}.####.png", "--stats", "{scene}.json"],
        ]
        .concat(),
    );
    for name in names {
        for file in [
            format!("o/{name}/{name}.0001.png"),
            format!("o/{name}/ids.json"),
            format!("{name}.json"),
            format!("{name}.depth.1.png"),
        ] {
            assert!(folder.path(&file).exists(), "{file}: {:?}", folder.names());
        }
    }
    // One scene, whose name is a field for the frame's number and that of an eye.
    folder.write("{eye}#.toml", SMALL_SCENE);
    render(
        &folder,
        &["{eye}#.toml", "--stereo", "ipd=0.1", "-o", "{scene}.{eye}.png"],
    );
    render(&folder, &["{eye}#.toml", "--stereo", "ipd=0.1"]);
    for eye in ["left", "right"] {
        for name in [format!("{{eye}}#.{eye}.png"), format!("{{eye}}#.{eye}.0001.exr")] {
            assert!(folder.path(&name).exists(), "{name}: {:?}", folder.names());
        }
    }
}

#[test]
fn eyes_without_names_of_their_own_have_files_of_their_own() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    render(&folder, &["s.toml", "--stereo", "ipd=0.1"]);
    render(&folder, &["s.toml", "--stereo", "ipd=0.1,eye=left", "-o", "alone.exr"]);
    assert!(folder.read("s.left.0001.exr") == folder.read("alone.exr"));
    assert!(folder.read("s.right.0001.exr") != folder.read("alone.exr"));
    assert!(!folder.path("s.0001.exr").exists());
}

#[test]
fn files_that_scenes_or_eyes_would_share_are_refused_before_the_first_is_rendered() {
    let folder = Folder::new();
    folder.write("s.toml", &with_files("[\"frame.####.png\"]"));
    folder.write("t.toml", &with_files("[\"./frame.%04d.png\"]"));
    for name in ["p1", "p2"] {
        fs::create_dir(folder.path(name)).expect("a folder");
        folder.write(&format!("{name}/box.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    }
    let submit = ["submit", "--engine", "slurm", "--bundle", "job"];
    for (job, expected) in [
        (
            &["s.toml", "--stereo", "ipd=0.1"][..],
            "both eyes would write frame.####.png",
        ),
        (&["s.toml", "t.toml"], "several scenes would write frame.####.png"),
        (&["p1/box.obj", "p2/box.obj"], "several scenes would write box.####.exr"),
        (
            &[
                "s.toml",
                "--stereo",
                "ipd=0.1",
                "-o",
                "{eye}.png",
                "--stats",
                "s.json",
                "--preview",
                "p.png",
            ],
            "both eyes would write p.png",
        ),
        (
            &[&submit[..], &["s.toml", "--stereo", "ipd=0.1"]].concat(),
            "both eyes would write frame.####.png",
        ),
    ] {
        let said = folder.fail(2, job);
        assert!(said.contains(expected), "{said}");
        assert!(said.contains("/####.exr'"), "{said}");
    }
    let names = folder.names();
    assert!(!names.iter().any(|name| name.starts_with("frame")), "{names:?}");
    // Numbers at the end of names meet at some frames alone.
    for name in ["car", "car1"] {
        folder.write(&format!("{name}.toml"), SMALL_SCENE);
    }
    let job = ["car.toml", "car1.toml", "-o", "{scene}#.png", "--turntable"];
    render(&folder, &[&job[..], &["9"]].concat());
    fs::remove_file(folder.path("car19.png")).expect("removed");
    let said = folder.fail(1, &[&job[..], &["12"], &SMALL[..]].concat());
    assert!(said.contains("several scenes would write car1"), "{said}");
    assert!(!folder.path("car19.png").exists());
}

#[test]
fn fields_of_names_in_the_files_of_a_scene_mean_what_flags_mean() {
    let folder = Folder::new();
    folder.write("s.toml", &with_files("[\"{scene}/{eye}/{scene}.####.png\"]"));
    folder.write("a#b.toml", &with_files("[\"{scene}.####.png\"]"));
    render(&folder, &["s.toml", "--stereo", "ipd=0.1", "--metadata", "ids"]);
    for name in [
        "s/left/s.0001.png",
        "s/right/s.0001.png",
        "s/left/ids.json",
        "s/right/ids.json",
    ] {
        assert!(folder.path(name).exists(), "{name}");
    }
    render(&folder, &["a#b.toml"]);
    assert!(folder.path("a#b.0001.png").exists(), "{:?}", folder.names());
    // Without stereo there is no eye; other files may replace those of the scene, which can be checked.
    for job in [
        &["s.toml"][..],
        &["s.toml", "-o", "x/{eye}.png"],
        &["s.toml", "-o", "x.png", "--stats", "{eye}.json"],
    ] {
        let said = folder.fail(2, &[job, &SMALL[..]].concat());
        assert!(
            said.contains("{eye} is the eye of --stereo, which is missing"),
            "{said}"
        );
    }
    render(&folder, &["s.toml", "-o", "x.png"]);
    folder.succeed(&["check", "s.toml"]);
}

#[test]
fn files_that_exist_are_refused_before_any_eye_or_scene_is_rendered() {
    let folder = Folder::new();
    for name in ["s.toml", "t.toml"] {
        folder.write(name, SMALL_SCENE);
    }
    for (job, there, other) in [
        (
            &["s.toml", "--stereo", "ipd=0.1", "-o", "{eye}.png"][..],
            "right.png",
            "left.png",
        ),
        (&["s.toml", "t.toml", "-o", "{scene}.#.png"], "t.1.png", "s.1.png"),
    ] {
        folder.write(there, "");
        let said = folder.fail(73, &[job, &["--fail-existing"], &SMALL[..]].concat());
        assert!(said.contains(there), "{said}");
        assert!(!folder.path(other).exists());
        fs::remove_file(folder.path(there)).expect("removed");
        render(&folder, &[job, &["--fail-existing"]].concat());
    }
}
