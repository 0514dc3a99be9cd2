//! Several scenes in one command.

use std::{
    fs,
    process::{Command, Stdio},
};

use crate::common::{Folder, SMALL_SCENE, stderr};

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
    wrong(&["-o", "{scene}.exr", "--stats", "./b.toml"], "./b.toml");
    wrong(&["-o", "{scene}.exr", "--metadata", "ids"], "would write ids.json");
    wrong(&["-o", "{scene}.exr", "--png-depth"], "would write depth.####.png");
    wrong(
        &["-o", "-", "--output-format", "png"],
        "standard output holds the frames of one scene",
    );
    wrong(&["-"], "standard input (-) is one scene");
    std::fs::create_dir(folder.path("in")).expect("made");
    let whole = folder.path("a.toml");
    for same in ["./a.toml", "in/../a.toml", whole.to_str().expect("UTF-8")] {
        let said = folder.fail(2, &["a.toml", "b.toml", same, "-o", "{scene}.exr"]);
        let expected = format!("the scene is named twice, as a.toml and as {same}");
        assert!(said.contains(&expected), "{said}");
    }
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let said = folder.fail(2, &["a.toml", "a.obj", "-o", "{scene}.exr"]);
    assert!(said.contains("two scenes have the name of a.obj"), "{said}");
    // One scene has a name, too; without -o files have the names of their scenes.
    folder.succeed(&[&["a.toml", "-o", "{scene}/{scene}.png"], &SMALL[..]].concat());
    folder.succeed(&[&["a.toml", "b.toml"], &SMALL[..]].concat());
    for name in ["a/a.png", "a.0001.exr", "b.0001.png"] {
        assert!(folder.path(name).exists(), "{name}: {:?}", folder.names());
    }
}

const AHEAD: &str = "loaded while the scene before it was rendered";

/// Runs the program with these arguments and `-v`, and returns what it logs.
fn logged(folder: &Folder, args: &[&str]) -> String {
    let output = folder.run(&[args, &["-v"], &SMALL[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    stderr(&output)
}

#[test]
fn the_next_scene_is_loaded_meanwhile_unless_it_is_large() {
    let folder = folder();
    let log = logged(&folder, &["a.toml", "b.toml", "-o", "{scene}.exr"]);
    assert!(
        log.contains(&format!("b.toml: {AHEAD}")) && !log.contains(&format!("a.toml: {AHEAD}")),
        "{log}"
    );

    // A picture of 8 MiB is more than a quarter of 24 MiB.
    image::RgbImage::from_pixel(2048, 1024, image::Rgb([90, 120, 150]))
        .save(folder.path("p.png"))
        .expect("a picture");
    let large = SMALL_SCENE.replace(
        "checker = { a = [0.9, 0.9, 0.9], b = [0.1, 0.1, 0.1], scale = 6 }",
        "image = { file = \"p.png\" }",
    );
    folder.write("large.toml", &large);
    let job = |limit: &'static str| {
        [
            "a.toml",
            "large.toml",
            "b.toml",
            "-o",
            "{scene}.exr",
            "--max-memory",
            limit,
        ]
    };
    let log = logged(&folder, &job("24M"));
    assert!(!log.contains(&format!("large.toml: {AHEAD}")), "{log}");
    assert!(
        log.contains(&format!("b.toml: {AHEAD}")) && !log.contains("error"),
        "{log}"
    );
    let small = folder.read("large.exr");
    let log = logged(&folder, &job("1G"));
    assert!(log.contains(&format!("large.toml: {AHEAD}")), "{log}");
    assert!(folder.read("large.exr") == small);
}

#[test]
fn a_scene_shows_what_an_earlier_one_has_just_rendered() {
    let folder = folder();
    let showing = SMALL_SCENE.replace(
        "checker = { a = [0.9, 0.9, 0.9], b = [0.1, 0.1, 0.1], scale = 6 }",
        "image = { file = \"a.png\" }",
    );
    folder.write("b.toml", &showing);
    let job = ["a.toml", "b.toml", "-o", "{scene}.png"];
    // Once the picture is missing when the scene could be loaded ahead, and once it is another.
    for _ in 0..2 {
        logged(&folder, &job);
        let together = folder.read("b.png");
        folder.succeed(&[&["b.toml", "-o", "{scene}.png"], &SMALL[..]].concat());
        assert!(folder.read("b.png") == together);
        image::RgbImage::new(16, 12)
            .save(folder.path("a.png"))
            .expect("a picture");
    }
    // The same picture again is no reason.
    logged(&folder, &["a.toml", "-o", "{scene}.png"]);
    let log = logged(&folder, &job);
    assert!(log.contains(&format!("b.toml: {AHEAD}")), "{log}");
}

#[cfg(unix)]
#[test]
fn a_signal_ends_the_command_and_leaves_nothing_of_the_scene_ahead() {
    let folder = folder();
    let mut program = folder.program_with_signals();
    let args = [
        "a.toml",
        "b.toml",
        "-o",
        "{scene}.####.exr",
        "--progress",
        "json",
        "--samples",
        "1000000",
    ];
    let mut child = program
        .args(args)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(child.stdout.take().expect("piped")));
    assert!(lines.next().expect("a line").expect("UTF-8").contains("frame_started"));
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(status.expect("kill runs").success());
    assert_eq!(lines.count(), 0);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert_eq!(folder.names(), ["a.toml", "b.toml"]);
}

/// The figures in a file.
fn figures(folder: &Folder, name: &str) -> serde_json::Value {
    serde_json::from_slice(&folder.read(name)).expect("JSON")
}

#[test]
fn one_file_has_the_figures_of_all_scenes_and_keeps_them() {
    let folder = folder();
    folder.write("broken.toml", "[camera");
    let job = [
        "a.toml",
        "broken.toml",
        "b.toml",
        "--views",
        "cube",
        "-o",
        "{scene}.#.exr",
        "--stats",
        "s.json",
    ];
    let job = [&job[..], &SMALL[..]].concat();
    folder.fail(1, &job);
    let all = figures(&folder, "s.json");
    let scenes = all["scenes"].as_array().expect("scenes");
    let of = |key: &str| -> Vec<&str> {
        scenes
            .iter()
            .map(|scene| scene[key].as_str().expect("a text"))
            .collect()
    };
    assert_eq!(of("name"), ["a", "broken", "b"]);
    assert_eq!(of("scene"), ["a.toml", "broken.toml", "b.toml"]);
    assert_eq!(of("state"), ["finished", "failed", "finished"]);
    assert_eq!((&all["state"], &all["is_finished"]), (&"failed".into(), &false.into()));
    assert!(
        scenes[1]["reason"]
            .as_str()
            .is_some_and(|reason| reason.contains("broken.toml")),
        "{all}"
    );
    assert!(scenes[1].get("figures").is_none() && scenes[0].get("reason").is_none());
    for scene in [&scenes[0], &scenes[2]] {
        let frames = scene["figures"]["frames"].as_array().expect("frames");
        assert_eq!((frames.len(), &scene["figures"]["scene"]), (6, &scene["scene"]));
        assert!(frames.iter().all(|frame| frame["status"] == "written"));
    }

    // A job that goes on keeps the figures of what is there.
    let before = scenes[0]["figures"]["frames"].clone();
    folder.write("broken.toml", SMALL_SCENE);
    folder.succeed(&[&job[..], &["--skip-existing"]].concat());
    let all = figures(&folder, "s.json");
    assert_eq!((&all["state"], &all["is_finished"]), (&"finished".into(), &true.into()));
    assert_eq!(all["scenes"][0]["figures"]["frames"], before);
    assert_eq!(all["scenes"][1]["state"], "finished");

    // One that does not begins anew, and one that may replace nothing is refused before the first scene.
    folder.succeed(&job);
    assert!(figures(&folder, "s.json")["scenes"][0]["figures"]["frames"] != before);
    let said = folder.fail(
        73,
        &[
            &[
                "a.toml",
                "b.toml",
                "-o",
                "new-{scene}.exr",
                "--stats",
                "s.json",
                "--fail-existing",
            ],
            &SMALL[..],
        ]
        .concat(),
    );
    assert!(said.contains("s.json") && !folder.path("new-a.exr").exists(), "{said}");
    folder.succeed(
        &[
            &[
                "a.toml",
                "b.toml",
                "-o",
                "new-{scene}.exr",
                "--stats",
                "t.json",
                "--fail-existing",
            ],
            &SMALL[..],
        ]
        .concat(),
    );
    assert_eq!(figures(&folder, "t.json")["is_finished"], true);
}

#[test]
fn parts_of_several_scenes_make_one_file_and_one_page() {
    let folder = folder();
    let part = |part: &str| {
        let job = [
            "a.toml",
            "b.toml",
            "--views",
            "cube",
            "-o",
            "{scene}.#.exr",
            "--part",
            part,
            "--stats",
            "f/s.json",
            "--report",
            "page",
        ];
        folder.succeed(&[&job[..], &SMALL[..]].concat());
        figures(&folder, "f/s.json")
    };
    let half = part("1/2");
    assert_eq!(
        (&half["state"], &half["is_finished"]),
        (&"finished".into(), &false.into())
    );
    let whole = part("2/2");
    assert_eq!(whole["is_finished"], true);
    for scene in 0..2 {
        let numbers = |all: &serde_json::Value| -> Vec<i64> {
            let frames = all["scenes"][scene]["figures"]["frames"].as_array().expect("frames");
            frames
                .iter()
                .map(|frame| frame["frame"].as_i64().expect("a number"))
                .collect()
        };
        assert_eq!((numbers(&half), numbers(&whole)), (vec![1, 2, 3], (1..=6).collect()));
    }
    let page = String::from_utf8(folder.read("page/index.html")).expect("UTF-8");
    for name in ["a", "b"] {
        assert!(
            page.contains(&format!("<a href=\"{name}/index.html\">{name}</a>")),
            "{page}"
        );
        let own = String::from_utf8(folder.read(&format!("page/{name}/index.html"))).expect("UTF-8");
        assert!(own.contains("6 frames written"), "{own}");
    }
    assert!(
        page.contains("<td>6 of 6</td><td>0</td>") && page.contains("data:image/png"),
        "{page}"
    );
    // With the name of the scene each has files of its own.
    folder.succeed(
        &[
            &[
                "a.toml",
                "b.toml",
                "-o",
                "{scene}.exr",
                "--stats",
                "{scene}.json",
                "--report",
                "own-{scene}",
            ],
            &SMALL[..],
        ]
        .concat(),
    );
    assert_eq!(figures(&folder, "a.json")["scene"], "a.toml");
    assert!(folder.path("own-b/index.html").exists() && !folder.path("own-b/b").exists());
}

/// The files of a scene, or of an eye of it.
const PATTERN: &str = "{scene}.{eye}.#.png";

#[test]
fn lines_of_events_name_the_scene_and_the_eye() {
    let folder = folder();
    let job = ["--turntable", "2", "--progress", "json", "-o"];
    let lines = |more: &[&str]| -> Vec<(String, String)> {
        let pattern = if more.contains(&"--stereo") {
            PATTERN
        } else {
            "{scene}.#.png"
        };
        let said = folder.succeed(&[more, &job, &[pattern], &SMALL[..]].concat());
        let text = |line: &serde_json::Value, key: &str| line[key].as_str().unwrap_or("none").to_owned();
        let lines = said.lines().map(|line| {
            let line = serde_json::from_str(line).unwrap_or_else(|e| panic!("{line}: {e}"));
            (text(&line, "scene"), text(&line, "eye"))
        });
        lines.collect()
    };
    let of = |scene: &str, eye: &str| vec![(scene.to_owned(), eye.to_owned()); 2 * 4];
    assert_eq!(lines(&["a.toml"]), of("a.toml", "none"));
    assert_eq!(
        lines(&["a.toml", "b.toml"]),
        [of("a.toml", "none"), of("b.toml", "none")].concat()
    );
    let eyes = ["a.toml", "--stereo", "ipd=0.06"];
    assert_eq!(lines(&eyes), [of("a.toml", "left"), of("a.toml", "right")].concat());
}

#[cfg(unix)]
#[test]
fn the_command_for_a_failed_frame_renders_it_of_its_scene_and_eye_alone() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let job = [
        "a.toml",
        "b.toml",
        "--stereo=ipd=0.06,convergence=2",
        "--turntable=3",
        "-o",
        PATTERN,
        "--stats=s.json",
        "--retries=0",
    ];
    let job = [&job[..], &SMALL[..]].concat();
    folder.succeed(&job);
    let closed = "b.right.2.png";
    let whole = folder.read(closed);
    fs::set_permissions(folder.path(closed), fs::Permissions::from_mode(0o444)).expect("set");
    let said = folder.fail(1, &job);
    let command = said.split_once("frame 2: ").and_then(|(_, rest)| rest.lines().next());
    let command = command.and_then(|line| line.split_once("to repeat it alone: "));
    let (_, command) = command.unwrap_or_else(|| panic!("no command: {said}"));
    let names = folder.names();
    let figures = folder.read("s.json");
    for name in &names {
        if name.ends_with(".png") {
            fs::remove_file(folder.path(name)).expect("removed");
        }
    }
    let words = shlex::split(command).expect("a command line");
    folder.succeed(&words[1..].iter().map(String::as_str).collect::<Vec<_>>());
    assert!(folder.read(closed) == whole);
    assert!(folder.read("s.json") == figures, "{command}");
    let pictures = folder.names().into_iter().filter(|name| name.ends_with(".png"));
    assert_eq!(pictures.collect::<Vec<_>>(), [closed]);
}
