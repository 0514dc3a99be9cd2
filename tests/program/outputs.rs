//! The places of a job's files: their names, what must not be replaced, and what counts as whole.

use std::{
    fs,
    process::Stdio,
    thread::sleep,
    time::{Duration, Instant},
};

use crate::common::{Folder, SMALL_SCENE, names, stderr};

/// One sample of few pixels, and no lines of progress.
const QUICK: [&str; 6] = ["--resolution", "16x12", "--samples", "1", "--progress", "none"];

fn quick<'a>(args: &[&'a str]) -> Vec<&'a str> {
    [args, &QUICK].concat()
}

fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder
}

#[test]
fn names_of_scenes_and_folders_are_taken_literally() {
    let folder = prepared();
    folder.write("shot #3 at 100% $F.toml", SMALL_SCENE);
    folder.succeed(&quick(&["shot #3 at 100% $F.toml"]));
    let made = ["shot #3 at 100% $F.0001.exr", "shot #3 at 100% $F.0001.png"];
    assert!(
        made.iter().all(|name| folder.path(name).is_file()),
        "{:?}",
        folder.names()
    );

    folder.succeed(&quick(&[
        "s.toml",
        "-o",
        "Take #2/final.exr",
        "-o",
        "Take #2/%#%%.#.png",
    ]));
    assert_eq!(names(&folder.path("Take #2")), ["#%.1.png", "final.exr"]);
}

#[test]
fn an_output_that_is_an_input_is_refused_by_whatever_name() {
    let folder = prepared();
    folder.succeed(&quick(&["s.toml", "-o", "grid.png"]));
    let textured = SMALL_SCENE.replace(
        "checker = { a = [0.9, 0.9, 0.9], b = [0.1, 0.1, 0.1], scale = 6 }",
        "image = { file = \"grid.png\" }",
    );
    folder.write("textured.toml", &textured);
    let before = folder.read("grid.png");
    fs::create_dir(folder.path("sub")).expect("a folder");
    let mut outputs = vec!["grid.png", "./sub/../grid.png"];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("grid.png", folder.path("link.png")).expect("a link");
        outputs.push("link.png");
    }
    fs::hard_link(folder.path("grid.png"), folder.path("hard.png")).expect("a link");
    outputs.push("hard.png");
    for output in outputs {
        let message = folder.fail(2, &quick(&["textured.toml", "-o", output]));
        assert!(
            message.contains("is a file that the job reads: ") && message.contains(output),
            "{message}"
        );
        assert_eq!(folder.read("grid.png"), before);
    }
}

/// The bytes with zeros from `from` on, for `count` of them.
fn hollow(bytes: &[u8], from: usize, count: usize) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[from..from + count].fill(0);
    bytes
}

#[test]
fn files_with_holes_are_rendered_again() {
    let folder = prepared();
    let skip = |file: &str| {
        let args = ["s.toml", "--skip-existing", "-o", file, "--samples", "1"];
        folder.succeed(&args).contains("skipped")
    };
    for file in ["a.exr", "b.png"] {
        assert!(!skip(file), "{file} was not there");
        assert!(skip(file), "{file} is whole");
    }
    let (exr, png) = (folder.read("a.exr"), folder.read("b.png"));
    let half = exr.len() / 2;
    let holes = [
        ("a.exr", hollow(&exr, half, exr.len() - half)),
        ("a.exr", hollow(&exr, half, 64)),
        ("b.png", hollow(&png, png.len() / 2, 100)),
        // A header and an end.
        ("b.png", [&png[..33], &png[png.len() - 12..]].concat()),
    ];
    for (file, bytes) in holes {
        fs::write(folder.path(file), bytes).expect("writable");
        assert!(!skip(file), "{file} is not whole");
    }
    assert_eq!((folder.read("a.exr"), folder.read("b.png")), (exr, png));
}

#[cfg(target_os = "linux")]
#[test]
fn a_pipe_at_an_outputs_place_is_refused_at_once() {
    let folder = prepared();
    let made = std::process::Command::new("mkfifo").arg(folder.path("a.png")).status();
    assert!(made.expect("mkfifo").success());
    let start = Instant::now();
    for flag in ["--skip-existing", "--samples=1"] {
        let message = folder.fail(73, &["s.toml", "-o", "a.png", flag, "--progress", "none"]);
        assert!(message.contains("it is not a regular file: a.png"), "{message}");
    }
    assert!(start.elapsed() < Duration::from_secs(20));
}

#[cfg(target_os = "linux")]
#[test]
fn a_listing_that_cannot_be_written_is_no_success() {
    let folder = prepared();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
    let output = folder
        .program()
        .args(["s.toml", "--dry-run"])
        .stdout(full)
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(74), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("cannot write to standard output"),
        "{}",
        stderr(&output)
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_vanishes_is_no_success() {
    let folder = prepared();
    folder.write("path.csv", crate::common::SMALL_PATH);
    let child = folder
        .program()
        .args(["s.toml", "--frames", "path.csv", "-o", "out/f.#.exr"])
        .args(["--samples", "300", "--resolution", "200x200", "--progress", "none"])
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let start = Instant::now();
    while !folder.path("out").is_dir() {
        assert!(start.elapsed() < Duration::from_secs(60), "the job makes its folder");
        sleep(Duration::from_millis(5));
    }
    while fs::remove_dir_all(folder.path("out")).is_err() {
        sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(73), "{}", stderr(&output));
}

/// Starts a job of one frame of many samples, and waits until it renders.
#[cfg(target_os = "linux")]
fn long_frame(folder: &Folder, wrapper: &[&str]) -> std::process::Child {
    let program = env!("CARGO_BIN_EXE_batch-render");
    let mut words = wrapper.to_vec();
    words.push(program);
    let child = std::process::Command::new(words[0])
        .args(&words[1..])
        .args(["s.toml", "-o", "f.exr", "--samples", "65536", "--resolution", "64x48"])
        .args(["--progress", "none"])
        .current_dir(folder.path(""))
        .spawn()
        .expect("the program starts");
    sleep(Duration::from_secs(2));
    child
}

#[cfg(target_os = "linux")]
fn signal(child: &std::process::Child, name: &str) {
    let id = child.id().to_string();
    let sent = std::process::Command::new("kill").args(["-s", name, &id]).status();
    assert!(sent.expect("kill").success());
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_ends_a_frame_of_any_number_of_samples_within_half_a_second() {
    let folder = prepared();
    let mut child = long_frame(&folder, &["env"]);
    signal(&child, "TERM");
    let start = Instant::now();
    assert_eq!(child.wait().expect("it ends").code(), Some(143));
    assert!(start.elapsed() < Duration::from_millis(500), "{:?}", start.elapsed());
    assert_eq!(folder.names(), ["s.toml"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_that_the_parent_ignores_stays_ignored() {
    let folder = prepared();
    let mut child = long_frame(&folder, &["sh", "-c", "trap '' INT; exec \"$0\" \"$@\""]);
    signal(&child, "INT");
    sleep(Duration::from_secs(1));
    assert!(child.try_wait().expect("a status").is_none(), "it goes on");
    signal(&child, "TERM");
    assert_eq!(child.wait().expect("it ends").code(), Some(143));
}

#[cfg(target_os = "linux")]
#[test]
fn what_killed_jobs_leave_is_removed_by_the_next_one() {
    let folder = prepared();
    folder.write(".batch-render-abcdefghij.tmp", "half a frame");
    folder.succeed(&quick(&["s.toml", "-o", "f.png"]));
    assert_eq!(folder.names(), ["f.png", "s.toml"]);
}

#[test]
fn a_job_that_stops_says_how_many_frames_are_on_disk() {
    let folder = prepared();
    folder.write("path.csv", crate::common::SMALL_PATH);
    fs::create_dir(folder.path("f.3.png")).expect("a folder in the way");
    let args = ["s.toml", "--frames", "path.csv", "-o", "f.#.png", "--range", "1-2"];
    let done = folder.run(&quick(&args));
    assert!(done.status.success());
    let output = folder.run(&["s.toml", "--frames", "path.csv", "-o", "f.#.png", "--samples", "1"]);
    assert_eq!(output.status.code(), Some(73));
    let said = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(said.ends_with("0 of 5 frames are on disk\n"), "{said}");
}

#[test]
fn a_jpeg_file_is_nearer_to_the_picture_the_higher_its_quality() {
    let folder = prepared();
    folder.write(
        "low.toml",
        &format!("{SMALL_SCENE}\n[output]\nfiles = \"low.jpg\"\njpeg_quality = 5\n"),
    );
    let picture = |name: &str, more: &[&str]| {
        folder.succeed(&quick(&[&["s.toml", "-o", name], more].concat()));
        image::load_from_memory(&folder.read(name))
            .expect("a picture")
            .into_rgb8()
    };
    let truth = picture("f.png", &[]);
    let error = |quality: &str| {
        let name = format!("{quality}.jpg");
        let found = picture(&name, &["--jpeg-quality", quality]);
        let pairs = found.iter().zip(truth.iter());
        pairs.map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum::<f64>()
    };
    let errors = ["1", "5", "30", "70", "95", "100"].map(error);
    assert!(errors.is_sorted_by(|a, b| a > b), "{errors:?}");
    picture("usual.jpg", &[]);
    assert!(folder.read("usual.jpg") == folder.read("95.jpg"));
    // By the scene file, and as a setting by which files are known again.
    let low = |more: &[&str]| folder.succeed(&[&["low.toml"], more, &QUICK[..4]].concat());
    low(&[]);
    let said = low(&["--skip-existing"]);
    assert!(said.contains("1 skipped"), "{said}");
    low(&["--skip-existing", "--jpeg-quality", "70"]);
    let pixels = |name: &str| {
        image::load_from_memory(&folder.read(name))
            .expect("a picture")
            .into_rgb8()
    };
    assert!(pixels("low.jpg") == pixels("70.jpg"));
    for wrong in ["0", "101", "-1", "9.5", "high"] {
        let said = folder.fail(2, &quick(&["s.toml", "-o", "f.jpg", "--jpeg-quality", wrong]));
        assert!(
            said.contains("--jpeg-quality: ") && said.contains("expected a whole number from 1 to 100"),
            "{said}"
        );
    }
}
