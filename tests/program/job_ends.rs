//! Messages of jobs about their end, and the files that they leave beside their pictures.

use std::{fs, process::Command};

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE, names, stderr};

const JOB: [&str; 9] = [
    "s.toml",
    "--frames",
    "path.csv",
    "--samples",
    "1",
    "--progress",
    "none",
    "-o",
    "o/f.####.exr",
];

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    folder
}

fn json(folder: &Folder, name: &str) -> serde_json::Value {
    serde_json::from_slice(&folder.read(name)).expect("JSON")
}

#[test]
fn a_part_is_finished_and_the_job_only_with_its_last_part() {
    let folder = folder();
    let job = [
        &JOB[..],
        &["--stats", "s.json", "--report", "page", "--metadata", "transforms"],
    ]
    .concat();
    let listed = || {
        json(&folder, "o/transforms.json")["frames"]
            .as_array()
            .expect("a list")
            .len()
    };
    let page = || fs::read_to_string(folder.path("page/index.html")).expect("a page");
    folder.succeed(&[&job[..], &["--part", "1/2"]].concat());
    let figures = json(&folder, "s.json");
    let facts =
        |figures: &serde_json::Value| ["total", "part", "state", "is_finished"].map(|key| figures[key].to_string());
    assert_eq!(facts(&figures), ["5", "\"1/2\"", "\"finished\"", "false"]);
    assert!(
        page().contains("<p>part 1/2 finished: 2 frames written, 0 skipped, 0 failed, of 5;"),
        "{}",
        page()
    );
    // Cameras of frames that nobody has rendered are not listed.
    assert_eq!(listed(), 2);
    folder.succeed(&[&job[..], &["--part", "2/2"]].concat());
    let figures = json(&folder, "s.json");
    assert_eq!(facts(&figures), ["5", "\"2/2\"", "\"finished\"", "true"]);
    assert!(
        page().contains("<p>finished: 5 frames written, 0 skipped, 0 failed, of 5;"),
        "{}",
        page()
    );
    assert_eq!(listed(), 5);
}

#[test]
fn a_preview_without_a_picture_is_in_the_exit_code() {
    let folder = folder();
    // An EXR file of a pass is no picture of a frame.
    let more = ["--show", "N", "--skip-existing", "--preview", "film.png"];
    folder.succeed(&[&JOB[..], &more].concat());
    let message = folder.fail(74, &[&JOB[..], &more, &["--quiet"]].concat());
    assert!(
        message.contains("no frame of the preview has a picture: film.png"),
        "{message}"
    );
}

#[test]
fn an_output_within_another_one_is_refused_before_the_first_ray() {
    let folder = folder();
    for args in [
        &["s.toml", "-o", "o/f.png", "--report", "o/f.png"][..],
        &["bench", "s.toml", "--json", "o/f.png", "--report", "o/f.png"],
    ] {
        let message = folder.fail(2, args);
        assert!(
            message.contains("an output is in a folder that is an output itself: "),
            "{message}"
        );
        assert!(!folder.path("o").exists());
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_is_no_file_for_the_figures_of_a_benchmark() {
    let folder = folder();
    let made = Command::new("mkfifo").arg(folder.path("pipe")).status();
    assert!(made.expect("mkfifo starts").success());
    for more in [&["--json", "pipe"][..], &["--picture", "--json", "pipe"]] {
        let message = folder.fail(73, &[&["bench", "s.toml"], more].concat());
        assert!(message.contains("it is not a regular file: pipe"), "{message}");
    }
}

#[cfg(unix)]
#[test]
fn a_file_beyond_the_limit_of_the_process_is_an_error_of_writing() {
    let folder = folder();
    let shell = Command::new("sh")
        .current_dir(folder.path(""))
        .args([
            "-c",
            "ulimit -f 1; exec \"$0\" \"$@\"",
            env!("CARGO_BIN_EXE_batch-render"),
        ])
        .args(["s.toml", "-q", "-o", "f.exr"])
        .output()
        .expect("a shell");
    let message = stderr(&shell);
    assert_eq!(shell.status.code(), Some(74), "{message}");
    assert!(
        message.contains("cannot write output: ") && message.contains("f.exr"),
        "{message}"
    );
    assert_eq!(folder.names(), ["path.csv", "s.toml"]);
}

#[cfg(unix)]
#[test]
fn locks_and_pipes_of_others_in_the_folder_keep_no_job_waiting() {
    let folder = folder();
    fs::create_dir(folder.path("o")).expect("made");
    for name in [".batch-render-x.job.tmp", "other"] {
        let made = Command::new("mkfifo").arg(folder.path("o").join(name)).status();
        assert!(made.expect("mkfifo starts").success());
    }
    let lock = fs::File::open(folder.path("o")).expect("a folder");
    lock.lock().expect("locked");
    folder.succeed(&JOB);
    assert_eq!(names(&folder.path("o")).len(), 7);
}

#[cfg(target_os = "linux")]
#[test]
fn arguments_that_are_not_utf8_work_as_others_do() {
    use std::{ffi::OsString, os::unix::ffi::OsStringExt};
    let folder = folder();
    let name = |start: &str, end: &str| OsString::from_vec([start.as_bytes(), b"\xff", end.as_bytes()].concat());
    fs::rename(folder.path("path.csv"), folder.path("").join(name("p", ".csv"))).expect("renamed");
    fs::create_dir(folder.path("o")).expect("made");
    folder.write("o/f.0002.exr", "");
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(folder.path("o/f.0002.exr"), fs::Permissions::from_mode(0o444)).expect("set");
    let mut program = folder.program();
    program.args([
        "s.toml",
        "--samples",
        "1",
        "--retries",
        "0",
        "-q",
        "-o",
        "o/f.####.exr",
        "--frames",
    ]);
    program.arg(name("p", ".csv")).arg("--stats").arg(name("s", ".json"));
    program
        .arg("--report")
        .arg(name("r", ""))
        .arg("--preview")
        .arg(name("f", ".png"));
    let output = program.output().expect("it starts");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("1 frame failed"), "{message}");
    for file in [name("s", ".json"), name("f", ".png"), name("r", "/index.html")] {
        assert!(folder.path("").join(&file).exists(), "{file:?}");
    }
}

/// Small frames are written together.
#[cfg(unix)]
#[test]
fn one_of_many_small_frames_that_cannot_be_written_fails_alone() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    fs::create_dir(folder.path("o")).expect("a folder");
    std::os::unix::fs::symlink("nowhere/x.png", folder.path("o/f.007.png")).expect("a link");
    let job = [
        "s.toml",
        "--turntable",
        "40",
        "--resolution",
        "4x3",
        "--samples",
        "1",
        "--progress",
        "none",
    ];
    let files = ["-o", "o/f.###.png", "-o", "o/f.###.npz", "--retries", "0"];
    let said = folder.fail(1, &[&job[..], &files].concat());
    assert!(
        said.contains("frame 7: ") && said.ends_with("error: 1 frame failed\n"),
        "{said}"
    );
    let names = crate::common::names(&folder.path("o"));
    let all = (1..=40).flat_map(|i| ["npz", "png"].map(|ending| format!("f.{i:03}.{ending}")));
    // Its first file, whose name is a link to nowhere, was to be written before the second.
    let expected: Vec<String> = all.filter(|name| name != "f.007.npz").collect();
    assert_eq!(names, expected);
    folder.succeed(&[&job[..], &["-r", "8", "-o", "alone.png", "-o", "alone.npz"]].concat());
    for ending in ["png", "npz"] {
        assert!(folder.read(&format!("o/f.008.{ending}")) == folder.read(&format!("alone.{ending}")));
    }
}
