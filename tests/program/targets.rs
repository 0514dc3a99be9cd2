//! Files that a job writes are never files that it reads, nor each other, under whatever name.

use std::fs;

use crate::common::Folder;

const SCENE: &str = "[render]\nwidth = 16\nheight = 12\nsamples = 2\n\
    [camera]\nperspective = { eye = [0, 1, 5], target = [0, 0.5, 0] }\n\
    [texture.t]\nimage = { file = \"tex.png\" }\n[material.m]\nmatte = { albedo = \"texture.t\" }\n\
    [[object]]\nmaterial = \"m\"\nshape.sphere = { radius = 1 }\n[background]\ncolor = 1\n";

/// A scene with a texture, and a folder that is a second name of the one that holds them.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SCENE);
    image::RgbImage::new(4, 4)
        .save(folder.path("tex.png"))
        .expect("written");
    fs::create_dir(folder.path("sub")).expect("made");
    folder
}

/// Demands that the program refuses these arguments, for this reason, and changes and makes nothing.
fn refused(folder: &Folder, args: &[&str], reason: &str) {
    let before: Vec<_> = ["s.toml", "tex.png"].map(|name| folder.read(name)).into();
    let names = folder.names();
    let message = folder.fail(2, args);
    assert!(message.contains(reason), "{args:?}: {message}");
    assert!(
        before == ["s.toml", "tex.png"].map(|name| folder.read(name)),
        "{args:?}"
    );
    assert_eq!(folder.names(), names, "{args:?}");
}

#[test]
fn files_beside_the_pictures_replace_no_input_and_no_picture() {
    let folder = folder();
    let job = ["s.toml", "-o", "f.exr", "-o", "f.png", "--progress", "none"];
    let reads = "is a file that the job reads";
    let twice = "two outputs are one file";
    for (flags, reason) in [
        (&["--stats", "s.toml"][..], reads),
        (&["--stats", "./sub/../tex.png"], reads),
        (&["--preview", "tex.png"], reads),
        (&["--stats", "f.png"], twice),
        (&["--preview", "sub/../f.png"], twice),
        (&["--stats", "film.png", "--preview", "./film.png"], twice),
        (&["--stats", "page/index.html", "--report", "page"], twice),
        (&["--stats", "transforms.json", "--metadata", "transforms"], twice),
        (&["--stats", "f.exr.checkpoint", "--checkpoint", "5s"], twice),
        (&["-o", "./f.exr"], ""),
    ] {
        refused(&folder, &[&job[..], flags].concat(), reason);
    }
    for flags in [["--check", "--stats=s.toml"], ["--dry-run", "--stats=s.toml"]] {
        let message = folder.fail(2, &[&job[..], &flags].concat());
        assert!(message.contains(reads), "{message}");
    }
}

#[cfg(unix)]
#[test]
fn links_to_inputs_are_inputs() {
    let folder = folder();
    fs::create_dir(folder.path("page")).expect("made");
    std::os::unix::fs::symlink("../tex.png", folder.path("page/index.html")).expect("linked");
    std::os::unix::fs::symlink("sub", folder.path("same")).expect("linked");
    let job = ["s.toml", "-o", "sub/f.png", "--progress", "none"];
    refused(
        &folder,
        &[&job[..], &["--report", "page"]].concat(),
        "is a file that the job reads",
    );
    refused(
        &folder,
        &[&job[..], &["--stats", "same/f.png"]].concat(),
        "two outputs are one file",
    );
}

#[test]
fn figures_of_a_comparison_replace_no_input() {
    let folder = folder();
    for flags in [&["--json", "tex.png"][..], &["--picture", "--json", "./s.toml"]] {
        let job = [&["bench", "s.toml", "--repetitions", "1"], flags].concat();
        refused(&folder, &job, "is a file that the job reads");
    }
}

#[test]
fn bench_measures_the_picture_that_the_flags_ask_for() {
    let folder = folder();
    folder.write(
        "path.csv",
        "frame,x,y,z,target_x,target_y,target_z\n1,0,1,5,0,0,0\n2,0,1,6,0,0,0\n",
    );
    let picture = ["--picture", "--repetitions", "1", "--json", "f.json"];
    let flags = [
        "--resolution",
        "8x6",
        "--samples",
        "3",
        "--frames",
        "path.csv",
        "--range",
        "2",
    ];
    folder.succeed(&[&["bench", "s.toml"], &picture[..], &flags].concat());
    let figures: serde_json::Value = serde_json::from_slice(&folder.read("f.json")).expect("JSON");
    assert_eq!(figures["resolution"], serde_json::json!([8, 6]));
    assert_eq!(figures["samples"], 3);
    let message = folder.fail(2, &["bench", "s.toml", "--samples", "3"]);
    assert!(message.contains("need --picture"), "{message}");
}

#[test]
fn bench_measures_the_scene_of_its_frame_with_its_blur() {
    let folder = folder();
    folder.write("v.csv", "frame,object.object 1.visible\n1,true\n2,false\n");
    let segments = |range: &str, shutter: &str| {
        let scene = SCENE.replace("\"texture.t\"", "0.5");
        let camera = format!("[camera]\nshutter = {shutter}\n");
        folder.write(
            "s.toml",
            &format!("values = \"v.csv\"\n{}", scene.replace("[camera]\n", &camera)),
        );
        let flags = ["--picture", "--repetitions", "1", "--json", "f.json", "--samples", "64"];
        folder.succeed(&[&["bench", "s.toml"], &flags[..], &["--range", range]].concat());
        let figures: serde_json::Value = serde_json::from_slice(&folder.read("f.json")).expect("JSON");
        figures["segments"].as_u64().expect("a number")
    };
    // Beyond the object there is the sky alone.
    let sky = 16 * 12 * 64;
    let there = segments("1", "[0, 0]") - sky;
    assert!(there > 1000, "{there}");
    assert_eq!(segments("2", "[0, 0]"), sky);
    let half = (segments("1", "[0.5, 1.5]") - sky) as f64;
    assert!((half / there as f64 - 0.5).abs() < 0.05, "{half} of {there}");
}

#[test]
fn denoised_frames_are_files_of_the_job() {
    let folder = folder();
    folder.write("s.toml", &SCENE.replace("tex.png", "tex.0001.exr"));
    let plain = SCENE
        .replace("\"texture.t\"", "0.5")
        .replace("[texture.t]\nimage = { file = \"tex.png\" }\n", "");
    folder.write("plain.toml", &plain);
    let job = [
        "plain.toml",
        "--turntable",
        "1",
        "--aovs",
        "denoise",
        "--progress",
        "none",
    ];
    folder.succeed(&[&job[..], &["-o", "tex.####.exr"]].concat());
    let texture = folder.read("tex.0001.exr");
    let job = ["s.toml", "--turntable", "1", "--denoise", "--progress", "none"];
    let over = [&job[..], &["-o", "./tex.####.exr"]].concat();
    refused(&folder, &over, "is a file that the job reads");
    let listed = folder.succeed(&[&job[..], &["-o", "d/f.#.exr", "--metadata", "ids", "--dry-run"]].concat());
    let listed = listed.replace(std::path::MAIN_SEPARATOR_STR, "/");
    assert!(
        listed.starts_with("1\td/noisy/f.1.exr\td/f.1.exr\n-\td/ids.json\n"),
        "{listed}"
    );
    fs::create_dir(folder.path("d")).expect("made");
    folder.write("d/f.1.exr", "keep");
    let message = folder.fail(73, &[&job[..], &["-o", "d/f.#.exr", "--fail-existing"]].concat());
    assert!(message.contains("exists already"), "{message}");
    assert_eq!(folder.read("d/f.1.exr"), b"keep");
    // A folder in the way is found before anything is rendered.
    fs::create_dir_all(folder.path("e/f.1.exr")).expect("made");
    folder.fail(73, &[&job[..], &["-o", "e/f.#.exr"]].concat());
    assert!(!folder.path("e/noisy").exists());
    // The sequence is not replaced by itself.
    let own = ["denoise", "tex.####.exr", "-o", "./sub/../tex.####.exr"];
    refused(&folder, &own, "is a file that the job reads");
    assert!(folder.read("tex.0001.exr") == texture);
}

#[test]
fn a_refused_job_leaves_older_figures() {
    let folder = folder();
    folder.write("stats.json", "keep");
    let job = ["s.toml", "--samples", "1", "--resolution", "4x4", "-o", "new.png"];
    let message = folder.fail(73, &[&job[..], &["--fail-existing", "--stats", "stats.json"]].concat());
    assert!(message.contains("exists already"), "{message}");
    assert_eq!(folder.read("stats.json"), b"keep");
    assert!(!folder.path("new.png").exists());
}

#[test]
fn the_picture_of_an_unfinished_frame_replaces_no_input() {
    let folder = folder();
    folder.write("s.toml", &SCENE.replace("tex.png", "tex.partial.exr"));
    let plain = SCENE
        .replace("\"texture.t\"", "0.5")
        .replace("[texture.t]\nimage = { file = \"tex.png\" }\n", "");
    folder.write("plain.toml", &plain);
    folder.succeed(&[
        "plain.toml",
        "-o",
        "tex.partial.exr",
        "--samples",
        "1",
        "--progress",
        "none",
    ]);
    refused(&folder, &["s.toml", "-o", "tex.exr"], "is a file that the job reads");
}
