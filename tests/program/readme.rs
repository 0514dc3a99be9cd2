//! The README and the guide are true: their commands run, their scenes render, the message is what one sees.

#![cfg(feature = "cli")]

use std::fs;

use crate::common::{Folder, repo, stderr};

/// The text of all code blocks in `language` of a document.
fn blocks(document: &str, language: &str) -> Vec<String> {
    let text = fs::read_to_string(repo(document)).expect("the document is there");
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

/// The arguments with the value of `flag` replaced or added.
fn with<'a>(mut args: Vec<&'a str>, flag: &'a str, value: &'a str) -> Vec<&'a str> {
    match args.iter().position(|a| *a == flag) {
        Some(at) => args[at + 1] = value,
        None => args.extend([flag, value]),
    }
    args
}

/// Runs a command as it is written, but with a small picture. Standard output may go to a file.
fn run(folder: &Folder, line: &str) {
    let (args, file) = line.split_once(" > ").unwrap_or((line, ""));
    let mut args: Vec<&str> = args.split_whitespace().collect();
    if args[0] == "bench" {
        args = with(with(args, "--repetitions", "1"), "--builds", "1");
    } else {
        // The denoiser compares halves of the samples, and adaptive sampling begins with 16.
        let (flag, samples) = if args.contains(&"--max-samples") {
            ("--max-samples", "16")
        } else if args.contains(&"--denoise") {
            ("--samples", "2")
        } else {
            ("--samples", "1")
        };
        args = with(with(args, "--resolution", "24x16"), flag, samples);
    }
    let output = folder.run(&args);
    assert!(output.status.success(), "{line}: {}", stderr(&output));
    if !file.is_empty() {
        fs::write(folder.path(file), output.stdout).expect("writable");
    }
}

#[cfg(unix)]
#[test]
fn every_command_of_the_readme_runs() {
    let folder = folder();
    let lines = blocks("README.md", "sh").concat();
    let mut renders = 0;
    for line in lines.lines().filter(|l| !l.trim().is_empty()) {
        let Some(args) = line.strip_prefix("cargo run --release -- ") else {
            assert_eq!(line, "cargo test", "a command that is not tried");
            continue;
        };
        run(&folder, args);
        renders += 1;
    }
    assert!(renders >= 6, "{renders}");
    let frames = crate::common::names(&folder.path("out/assignment"));
    assert_eq!((frames.len(), frames[1].as_str()), (120, "frame.0001.png"));
}

#[cfg(unix)]
#[test]
fn every_command_of_the_guide_runs_on_its_scene_and_its_path() {
    let folder = folder();
    let [table, cube, plate] = <[String; 3]>::try_from(blocks("docs/guide.md", "toml")).expect("three scenes");
    folder.write("table.toml", &table);
    folder.write("cube.toml", &cube);
    folder.write("path.csv", &blocks("docs/guide.md", "csv").swap_remove(0));
    let lines = blocks("docs/guide.md", "sh").concat();
    for line in lines.lines().filter(|l| !l.trim().is_empty()) {
        run(
            &folder,
            line.strip_prefix("batch-render ").expect("a command of the program"),
        );
    }
    assert_eq!(crate::common::names(&folder.path("turn")).len(), 8);
    assert!(folder.path("out/bench/bench.html").exists());
    assert_eq!(crate::common::names(&folder.path("pictures")).len(), 3);
    let film = folder.read("table.y4m");
    let frames = film.windows(6).filter(|part| *part == b"FRAME\n").count();
    assert!(film.starts_with(b"YUV4MPEG2 W24 H16 F25:1 ") && frames == 3);
    assert!(folder.read("table.gif").starts_with(b"GIF89a") && folder.path("arrays/table.npz").exists());
    let frames = ["table.0001.exr", "table.0049.exr", "table.0097.exr"];
    assert!(frames.iter().all(|frame| folder.path(frame).exists()));
    // A scene with a camera, and a model in it.
    folder.write("both.toml", &format!("{table}{cube}"));
    folder.succeed(&["check", "both.toml"]);
    // A scene that goes over a plate.
    folder.write("plate.toml", &plate);
    fs::copy(repo("scenes/kinds/sky.hdr"), folder.path("set.hdr")).expect("writable");
    run(&folder, "plate.toml -o plate.exr");
}

#[test]
fn the_scene_and_the_camera_path_render_and_the_message_is_as_shown() {
    let folder = folder();
    let scene = blocks("README.md", "toml").swap_remove(0);
    folder.write("ball.toml", &scene);
    folder.write("path.csv", &blocks("README.md", "csv").swap_remove(0));
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
    assert_eq!(
        stderr(&output).trim_end(),
        blocks("README.md", "text").swap_remove(0).trim_end()
    );
}
