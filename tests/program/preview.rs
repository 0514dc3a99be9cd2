//! The preview of a job: an animated PNG of its frames.

use std::io::Cursor;

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE, stderr};

const JOB: [&str; 9] = [
    "s.toml",
    "--frames",
    "path.csv",
    "--progress",
    "none",
    "-o",
    "f.####.png",
    "--preview",
    "film.png",
];

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    folder
}

/// The frames of the preview, and the time that each is shown, in seconds.
fn film(folder: &Folder) -> (Vec<Vec<u8>>, f64) {
    let mut reader = png::Decoder::new(Cursor::new(folder.read("film.png")))
        .read_info()
        .expect("a PNG");
    let count = reader.info().animation_control.expect("it is animated").num_frames;
    let mut delay = 0.0;
    let mut frames = Vec::new();
    for _ in 0..count {
        let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut bytes).expect("a frame");
        let control = reader.info().frame_control.expect("a frame of an animation");
        delay = f64::from(control.delay_num) / f64::from(control.delay_den);
        frames.push(bytes);
    }
    (frames, delay)
}

#[test]
fn a_preview_shows_every_frame_in_order_for_its_time() {
    let folder = folder();
    folder.succeed(&[&JOB[..], &["--fps", "12"]].concat());
    let (frames, delay) = film(&folder);
    assert!((delay - 1.0 / 12.0).abs() < 1e-9);
    assert_eq!(frames.len(), 5);
    // No picture is smaller than the limit here, so the preview holds the pixels of the files.
    for (frame, number) in frames.iter().zip(1..) {
        let file = image::load_from_memory(&folder.read(&format!("f.{number:04}.png"))).expect("a PNG");
        let differs = |(a, b): (&u8, &u8)| a.abs_diff(*b) > 1;
        assert!(!frame.iter().zip(file.into_rgb8().as_raw()).any(differs), "{number}");
    }
}

#[test]
fn transparent_frames_that_are_there_look_as_those_that_are_rendered() {
    let folder = folder();
    // Nothing is brighter than white, which is all that a PNG file holds.
    let dull = "matte = { albedo = [0.3, 0.5, 0.4] }";
    folder.write("s.toml", &SMALL_SCENE.replace("mirror = { reflectance = 0.9 }", dull));
    let job = [&JOB[..], &["--set=background.visible=false", "--exposure=-4"]].concat();
    folder.succeed(&job);
    let (rendered, _) = film(&folder);
    folder.succeed(&[&job[..], &["--skip-existing"]].concat());
    let (read, _) = film(&folder);
    assert!(rendered.iter().flatten().any(|value| *value > 0));
    for (frame, (a, b)) in rendered.iter().zip(&read).enumerate() {
        // Files hold the colour before it is covered, in 8 bits.
        let most = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(most <= Some(2), "frame {frame}: {most:?}");
    }
}

#[test]
fn frames_that_are_there_come_from_their_files() {
    let folder = folder();
    folder.succeed(&JOB);
    let (whole, _) = film(&folder);
    std::fs::remove_file(folder.path("f.0003.png")).expect("it is there");
    folder.succeed(&[&JOB[..], &["--skip-existing"]].concat());
    assert!(film(&folder).0 == whole, "as many frames, and the same");
}

#[test]
fn frames_that_are_there_as_exr_files_alone_equal_those_of_a_new_job() {
    let folder = folder();
    let job = [&JOB[..6], &["f.####.exr", "--preview", "film.png"]].concat();
    folder.succeed(&job);
    let (whole, _) = film(&folder);
    std::fs::remove_file(folder.path("f.0003.exr")).expect("it is there");
    folder.succeed(&[&job[..], &["--skip-existing"]].concat());
    let (again, _) = film(&folder);
    assert_eq!(again.len(), whole.len());
    // Numbers of half precision are rounded.
    let differs = |(a, b): (&u8, &u8)| a.abs_diff(*b) > 1;
    let differ = |(a, b): (&Vec<u8>, &Vec<u8>)| a.iter().zip(b).any(differs);
    assert!(!whole.iter().zip(&again).any(differ));
}

#[test]
fn a_film_needs_ffmpeg_and_other_endings_are_refused() {
    let folder = folder();
    let output = folder
        .program()
        .args(&JOB[..7])
        .args(["--preview", "film.mp4"])
        .env("PATH", "")
        .output()
        .expect("it runs");
    assert_eq!(output.status.code(), Some(2));
    let message = stderr(&output);
    assert!(
        message.contains("ffmpeg, which is not installed; --preview film.png needs no other program"),
        "{message}"
    );
    folder.fail(2, &[&JOB[..7], &["--preview", "film.gif"]].concat());
}

/// What is missing in a film of a job that was stopped is no fault.
#[cfg(unix)]
#[test]
fn a_job_that_is_stopped_says_nothing_of_its_films() {
    let folder = folder();
    for film in [["--preview", "film.png"], ["-o", "film.gif"]] {
        let mut program = folder.program_with_signals();
        let job = [
            "s.toml",
            "--frames",
            "path.csv",
            "-o",
            "f.####.png",
            "--samples",
            "1000000",
            "--progress",
            "json",
        ];
        let program = program.args(job).args(film);
        let piped = std::process::Stdio::piped;
        let mut child = program.stdout(piped()).stderr(piped()).spawn().expect("it starts");
        let mut lines = std::io::BufRead::lines(std::io::BufReader::new(child.stdout.take().expect("piped")));
        assert!(lines.next().expect("a line").expect("UTF-8").contains("frame_started"));
        let status = std::process::Command::new("kill")
            .args(["-TERM", &child.id().to_string()])
            .status();
        assert!(status.expect("kill runs").success());
        assert_eq!(lines.count(), 0);
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(
            (output.status.code(), &*stderr(&output)),
            (Some(143), "error: cancelled\n")
        );
    }
}
