//! The README is true: its commands run, its scene renders, its message is what one sees.

#![cfg(feature = "cli")]

mod common;

use std::fs;

use common::{Folder, repo, stderr};

fn readme() -> String {
    fs::read_to_string(repo("README.md")).expect("there is a README")
}

/// The text of all code blocks in `language`.
fn blocks(language: &str) -> Vec<String> {
    let text = readme();
    let open = format!("```{language}\n");
    let blocks = text.split(&open).skip(1);
    blocks
        .map(|rest| rest.split("```").next().expect("a block ends").to_owned())
        .collect()
}

/// A folder from which the repository's scenes are where they are for a reader.
fn folder() -> Folder {
    let folder = Folder::new();
    #[cfg(unix)]
    std::os::unix::fs::symlink(repo("scenes"), folder.path("scenes")).expect("a link");
    folder
}

/// What follows `flag`, replaced or added.
fn with<'a>(mut args: Vec<&'a str>, flag: &'a str, value: &'a str) -> Vec<&'a str> {
    match args.iter().position(|a| *a == flag) {
        Some(at) => args[at + 1] = value,
        None => args.extend([flag, value]),
    }
    args
}

#[cfg(unix)]
#[test]
fn every_command_runs() {
    let folder = folder();
    let lines = blocks("sh").concat();
    let mut renders = 0;
    for line in lines.lines().filter(|l| !l.trim().is_empty()) {
        let Some(args) = line.strip_prefix("cargo run --release -- ") else {
            assert_eq!(line, "cargo test", "a command that is not tried");
            continue;
        };
        let mut args: Vec<&str> = args.split_whitespace().collect();
        if args[0] == "bench" {
            args = with(with(args, "--repetitions", "1"), "--builds", "1");
        } else {
            args = with(with(args, "--resolution", "24x16"), "--samples", "1");
        }
        folder.succeed(&args);
        renders += 1;
    }
    assert!(renders >= 6, "{renders}");
    let frames = common::names(&folder.path("out/assignment"));
    assert_eq!((frames.len(), frames[1].as_str()), (120, "frame.0001.png"));
    assert!(folder.path("out/bench/bench.html").exists());
}

#[test]
fn the_scene_and_the_camera_path_render_and_the_message_is_as_shown() {
    let folder = folder();
    let scene = blocks("toml").swap_remove(0);
    folder.write("ball.toml", &scene);
    folder.write("path.csv", &blocks("csv").swap_remove(0));
    let small = ["--resolution", "24x16", "--samples", "1"];
    folder.succeed(
        &[
            &["ball.toml", "--frames", "path.csv", "--range", "1-100x33"],
            &small[..],
        ]
        .concat(),
    );
    assert_eq!(folder.names().iter().filter(|n| n.ends_with(".exr")).count(), 4);

    let wrong = scene.replace("center = [0, 1, 0], radius", "center = [0, 1, 0], radus");
    assert_ne!(wrong, scene);
    folder.write("ball.toml", &wrong);
    let output = folder.run(&["ball.toml"]);
    assert_eq!(output.status.code(), Some(65));
    assert_eq!(stderr(&output).trim_end(), blocks("text").swap_remove(0).trim_end());
}
