//! Frames on standard output, and scenes on standard input.

use std::{
    io::{Read as _, Write as _},
    process::{Output, Stdio},
};

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE, repo_str, stderr};

pub const SMALL: [&str; 5] = ["s.toml", "--resolution", "16x12", "--samples", "2"];
pub const FILM: [&str; 4] = ["--frames", "path.csv", "--range", "1-3"];

pub fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    folder
}

/// What a job with these further arguments writes to standard output.
fn streamed(folder: &Folder, more: &[&str]) -> Vec<u8> {
    let output = folder.run(&[&SMALL[..], more].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    output.stdout
}

#[test]
fn a_frame_on_standard_output_is_its_file_and_nothing_else() {
    let folder = folder();
    let formats = batch_render::output::FORMATS;
    for format in formats.iter().map(|format| format.name()) {
        let passes: &[&str] = if ["exr", "npz"].contains(&format) {
            &["--aovs", "depth"]
        } else {
            &[]
        };
        let name = format!("f.{format}");
        folder.succeed(&[&SMALL[..], &["-o", &name], passes].concat());
        for more in [&[][..], &["--progress", "plain"], &["--progress", "json"], &["-vv"]] {
            let bytes = streamed(
                &folder,
                &[&["-o", "-", "--output-format", format], passes, more].concat(),
            );
            assert!(bytes == folder.read(&name), "{format} {more:?}");
        }
    }
    assert_eq!(folder.names().len(), 2 + formats.len());
}

#[test]
fn files_of_a_sequence_follow_each_other_in_order_and_may_be_written_beside_it() {
    let folder = folder();
    for format in ["png", "jpg", "npz"] {
        let pattern = format!("f.#.{format}");
        let both = ["-o", "-", "--output-format", format, "-o", &pattern];
        let bytes = streamed(&folder, &[&FILM[..], &both].concat());
        let files: Vec<u8> = (1..=3)
            .flat_map(|frame| folder.read(&format!("f.{frame}.{format}")))
            .collect();
        assert!(bytes == files, "{format}");
    }
}

#[test]
fn a_film_has_a_header_and_frames_of_one_size() {
    let folder = folder();
    let film = streamed(
        &folder,
        &[&FILM[..], &["-o", "-", "--output-format", "y4m", "--fps", "30"]].concat(),
    );
    let header = "YUV4MPEG2 W16 H12 F30:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n";
    let frames = film.strip_prefix(header.as_bytes()).expect("the header");
    const FRAME: usize = 6 + 3 * 16 * 12;
    assert_eq!(frames.len(), 3 * FRAME);
    for frame in frames.chunks_exact(FRAME) {
        let values = frame.strip_prefix(b"FRAME\n").expect("a frame");
        assert!(values[..16 * 12].iter().all(|y| (16..=235).contains(y)));
        assert!(values[16 * 12..].iter().all(|c| (16..=240).contains(c)));
    }
}

#[test]
fn a_reader_that_goes_ends_the_job_quietly_with_the_code_of_sigpipe() {
    let folder = folder();
    let args = ["--turntable", "500", "-o", "-", "--output-format", "y4m"];
    let mut child = folder
        .program()
        .args([&SMALL[..], &args].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut first = [0; 9];
    child
        .stdout
        .take()
        .expect("it is piped")
        .read_exact(&mut first)
        .expect("a film");
    assert_eq!(&first, b"YUV4MPEG2");
    let output = child.wait_with_output().expect("ended");
    assert_eq!(output.status.code(), Some(141), "{}", stderr(&output));
    assert!(!stderr(&output).contains("error"), "{}", stderr(&output));
}

#[cfg(target_os = "linux")]
#[test]
fn an_error_that_ends_a_job_is_told_alone() {
    let folder = folder();
    let full = std::fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .expect("the device");
    let mut program = folder.program();
    let stream = ["-o", "-", "--output-format", "y4m", "--progress", "none"];
    program.args([&SMALL[..], &FILM[..], &stream].concat());
    let output = program.stdout(full).output().expect("it starts");
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(74), "{said}");
    assert!(said.starts_with("error: cannot write to standard output: "), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
}

#[test]
fn what_makes_no_sense_on_standard_output_is_refused() {
    let folder = folder();
    for (more, message) in [
        (&["-o", "-"][..], "-o -: --output-format tells the form"),
        (
            &["-o", "f.png", "--output-format", "png"],
            "--output-format is that of standard output",
        ),
        (&["-o", "-", "--output-format", "mp4"], "unknown format `mp4`"),
        (
            &["-o", "-", "--output-format", "y4m", "--skip-existing"],
            "would be missing",
        ),
        (
            &["-o", "-", "--output-format", "exr", "--turntable", "2"],
            "readers of EXR take one",
        ),
        (
            &["-o", "-", "--output-format", "png", "--aovs", "depth"],
            "only EXR and NPZ files hold passes",
        ),
        (
            &["-o", "-", "--output-format", "png", "--denoise"],
            "--denoise reads the frames again",
        ),
        (
            &["-o", "-", "--output-format", "png", "--metadata", "ids"],
            "--metadata writes files beside those of the frames",
        ),
        (
            &["-o", "-", "--output-format", "png", "--list-stale"],
            "the frames have no files",
        ),
    ] {
        let said = folder.fail(2, &[&SMALL[..], more].concat());
        assert!(said.contains(message), "{more:?}: {said}");
    }
    assert_eq!(folder.names(), ["path.csv", "s.toml"]);
}

/// Runs a job with this text on standard input.
fn with_input(folder: &Folder, text: &[u8], args: &[&str]) -> Output {
    let mut child = folder
        .program()
        .args(args)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    child
        .stdin
        .take()
        .expect("it is piped")
        .write_all(text)
        .expect("it reads");
    child.wait_with_output().expect("ended")
}

#[test]
fn scenes_and_models_on_standard_input_are_those_of_files() {
    let folder = Folder::new();
    let small = ["--resolution", "16x12", "--samples", "2", "--progress", "none"];
    let pixels = |bytes: &[u8]| image::load_from_memory(bytes).expect("a PNG");
    let model = std::fs::read(repo_str("scenes/cube/cube.obj")).expect("a model");
    for (form, text) in [("toml", SMALL_SCENE.as_bytes()), ("obj", &model)] {
        let name = format!("s.{form}");
        std::fs::write(folder.path(&name), text).expect("written");
        folder.succeed(&[&[name.as_str(), "-o", "f.png"], &small[..]].concat());
        let stream = ["-", "--input-format", form, "-o", "-", "--output-format", "png"];
        let output = with_input(&folder, text, &[&stream[..], &small].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        assert_eq!(pixels(&output.stdout), pixels(&folder.read("f.png")), "{form}");
    }
    let output = with_input(&folder, b"[render]\nwidht = 3\n", &["-", "--input-format", "toml"]);
    assert_eq!(output.status.code(), Some(65));
    assert!(stderr(&output).contains("stdin.toml:2"), "{}", stderr(&output));
    for (args, message) in [
        (&["-"][..], "--input-format tells its form"),
        (
            &["s.toml", "--input-format", "toml"],
            "--input-format is that of standard input",
        ),
        (
            &["-", "--input-format", "blend"],
            "expected toml, or the ending of a model",
        ),
    ] {
        let said = folder.fail(2, args);
        assert!(said.contains(message), "{said}");
    }
}

#[cfg(unix)]
#[test]
fn standard_input_that_cannot_be_read_is_an_error_of_reading() {
    let folder = folder();
    let input = std::fs::File::open(folder.path("")).expect("a folder");
    let mut program = folder.program();
    program.args(["-", "--input-format", "toml"]).stdin(input);
    let output = program.output().expect("it starts");
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(74), "{said}");
    assert!(said.contains("cannot read standard input: "), "{said}");
}
