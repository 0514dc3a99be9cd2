//! Jobs that denoise their frames: what they make and say is that of the denoised frames.

use std::{fs, io::Cursor};

use crate::common::{Folder, SMALL_SCENE, names, stderr};

const PATH: &str =
    "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n1,0,2,6,0,0.8,0\n3,0.2,2,6,0,0.8,0\n5,0.2,2,6,0,0.8,0\n";

/// Five frames, with noise that is seen.
const JOB: &str = "s.toml --frames p.csv --integrator path --set render.samples=8 --temporal 1 --denoise";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("p.csv", PATH);
    folder
}

/// The arguments in these lines.
fn words<'a>(lines: &[&'a str]) -> Vec<&'a str> {
    lines.iter().flat_map(|line| line.split(' ')).collect()
}

fn pixels(folder: &Folder, name: &str) -> Vec<u8> {
    let picture = image::load_from_memory(&folder.read(name)).expect("a picture");
    picture.into_rgb8().into_raw()
}

fn square_error(a: &[u8], b: &[u8]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
    squares.sum::<f64>() / a.len() as f64
}

/// The frames of an animated PNG.
fn film(folder: &Folder, name: &str) -> Vec<Vec<u8>> {
    let mut reader = png::Decoder::new(Cursor::new(folder.read(name)))
        .read_info()
        .expect("a PNG");
    let count = reader.info().animation_control.expect("it is animated").num_frames;
    let frames = (0..count).map(|_| {
        let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut bytes).expect("a frame");
        bytes
    });
    frames.collect()
}

fn stats(folder: &Folder, name: &str) -> serde_json::Value {
    serde_json::from_slice(&folder.read(name)).expect("JSON")
}

/// The status of each frame.
fn statuses(stats: &serde_json::Value) -> Vec<&str> {
    let frames = stats["frames"].as_array().expect("a list").iter();
    frames.map(|frame| frame["status"].as_str().expect("a text")).collect()
}

/// Sets whether a file may be written.
fn set_writable(folder: &Folder, name: &str, is_writable: bool) {
    let path = folder.path(name);
    let mut permissions = fs::metadata(&path).expect("a file").permissions();
    permissions.set_readonly(!is_writable);
    fs::set_permissions(path, permissions).expect("set");
}

#[test]
fn pictures_and_the_preview_of_a_denoised_job_are_nearer_to_the_truth_than_noisy_ones() {
    let folder = folder();
    let plain = "s.toml --frames p.csv --integrator path -q -r 4 --samples";
    folder.succeed(&words(&[plain, "8 -o noisy.png"]));
    folder.succeed(&words(&[plain, "512 --seed 99 -o truth.png"]));
    folder.succeed(&words(&[
        JOB,
        "-q -o f.#.exr -o f.#.png --preview film.png --report page --stats s.json",
    ]));
    let [noisy, truth, clean] = ["noisy.png", "truth.png", "f.4.png"].map(|name| pixels(&folder, name));
    let (before, after) = (square_error(&noisy, &truth), square_error(&clean, &truth));
    assert!(after < 0.7 * before, "{after} {before}");
    let film = film(&folder, "film.png");
    assert_eq!(film.len(), 5);
    assert!(
        film[3].iter().zip(&clean).all(|(a, b)| a.abs_diff(*b) <= 1),
        "the preview is clean"
    );
    let stats = stats(&folder, "s.json");
    assert!(stats["state"] == "finished" && stats["is_finished"] == true);
    assert_eq!(statuses(&stats), ["written"; 5]);
    assert_eq!(
        stats["frames"][3]["files"],
        serde_json::json!(["noisy/f.4.exr", "f.4.exr", "f.4.png"])
    );
    assert_eq!(
        fs::read_to_string(folder.path("page/index.html"))
            .expect("a page")
            .matches("<img")
            .count(),
        5
    );

    // Pictures alone are made of the same noisy files, and both halves know what is there.
    folder.succeed(&words(&[JOB, "-q -o alone/f.#.png"]));
    assert_eq!(names(&folder.path("alone/noisy")).len(), 5);
    assert!((1..=5).all(|i| folder.read(&format!("alone/f.{i}.png")) == folder.read(&format!("f.{i}.png"))));
    fs::remove_file(folder.path("alone/f.2.png")).expect("it is there");
    let job = words(&[JOB, "-o alone/f.#.png --skip-existing --preview again.png"]);
    let said = folder.succeed(&job);
    assert!(said.contains("0 frames rendered, 1 denoised, 4 skipped in "), "{said}");
    let again = self::film(&folder, "again.png");
    assert!(again.iter().zip(&film).all(|(a, b)| square_error(a, b) < 1.0) && again.len() == 5);
}

#[test]
fn a_step_that_denoises_keeps_figures_and_a_preview_of_its_frames() {
    let folder = folder();
    let job = "-q -o f.#.exr --preview film.png --report page --stats s.json --denoise-step";
    folder.succeed(&words(&[JOB, job, "render"]));
    let noisy = film(&folder, "film.png");
    folder.succeed(&words(&[JOB, job, "denoise"]));
    let clean = film(&folder, "film.png");
    assert!(clean.len() == 5 && noisy.len() == 5 && clean != noisy);
    let stats = stats(&folder, "s.json");
    assert_eq!(statuses(&stats), ["written"; 5]);
    assert_eq!(stats["frames"][0]["files"], serde_json::json!(["f.1.exr"]));
}

#[test]
fn events_of_a_job_that_denoises_are_json() {
    let folder = folder();
    let said = folder.succeed(&words(&[JOB, "-o f.#.exr --progress json"]));
    let events = said
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    assert_eq!(
        events.filter(|event| event["event"] == "frame_denoised").count(),
        5,
        "{said}"
    );
}

#[test]
fn the_last_part_of_a_step_that_denoises_makes_the_preview_of_all_frames() {
    let folder = folder();
    let job = "-q -o f.#.exr --preview film.png --denoise-step";
    for step in ["render", "denoise"] {
        for part in ["--part 1/3", "--part 2/3", "--part 3/3"] {
            folder.succeed(&words(&[JOB, job, step, part]));
        }
    }
    assert_eq!(film(&folder, "film.png").len(), 5);
}

#[test]
fn figures_of_denoised_frames_name_both_fingerprints_and_keep_times_of_earlier_runs() {
    let folder = folder();
    let job = "-q --resolution 14x10 -o f.#.exr --report page --stats s.json";
    for step in ["--part 1/2 --denoise-step render", "--part 2/2 --denoise-step render"] {
        folder.succeed(&words(&[JOB, job, step]));
    }
    let rendered = stats(&folder, "s.json");
    let attribute = |name: &str, key: &str| {
        let file = batch_render::output::ExrFile::read(&folder.path(name)).expect("an EXR file");
        file.attribute(key).expect("it is there").to_string()
    };
    let fingerprint = "batch-render/fingerprint";
    // The second half, and a job that skips all frames.
    for step in ["--denoise-step denoise", "--skip-existing"] {
        folder.succeed(&words(&[JOB, job, step]));
        let told = stats(&folder, "s.json");
        assert_eq!(statuses(&told), ["written"; 5]);
        for (i, (told, before)) in told["frames"]
            .as_array()
            .expect("a list")
            .iter()
            .zip(rendered["frames"].as_array().expect("a list"))
            .enumerate()
        {
            for key in ["wall_s", "samples", "segments", "peak_memory_bytes"] {
                assert_eq!(told[key], before[key], "{step} {key}");
            }
            assert!(told["wall_s"].as_f64() > Some(0.0));
            let number = i + 1;
            assert_eq!(told["fingerprint"], attribute(&format!("f.{number}.exr"), fingerprint));
            assert_eq!(
                told["noisy_fingerprint"],
                attribute(&format!("noisy/f.{number}.exr"), fingerprint)
            );
            assert_eq!(told["noisy_fingerprint"], before["fingerprint"]);
            assert_eq!(told["files"], serde_json::json!([format!("f.{number}.exr")]));
        }
        let page = fs::read_to_string(folder.path("page/index.html")).expect("a page");
        assert!(
            page.matches("<img").count() == 5 && page.contains("Time per frame"),
            "{step}"
        );
    }
}

#[test]
fn a_time_limit_that_suffices_changes_no_byte_and_a_short_one_leaves_two_halves() {
    let folder = folder();
    folder.succeed(&words(&[JOB, "-q -r 1-3 -o whole/f.#.exr"]));
    folder.succeed(&words(&[JOB, "-q -r 1-3 -o limited/f.#.exr --time-limit 1h"]));
    for name in ["noisy/f.1.exr", "noisy/f.3.exr", "f.2.exr"] {
        assert!(
            folder.read(&format!("whole/{name}")) == folder.read(&format!("limited/{name}")),
            "{name}"
        );
    }
    folder.succeed(&words(&[
        JOB,
        "-q -r 1-3 -o short/f.#.exr --set render.samples=100000 --time-limit 0.001s",
    ]));
    let file = batch_render::output::ExrFile::read(&folder.path("short/f.2.exr")).expect("an EXR file");
    let samples = file.attribute("batch-render/samples").expect("it is there").to_string();
    // 100000 halved until two or more are left.
    let stops: Vec<String> = std::iter::successors(Some(100_000), |n| Some(n / 2))
        .take(16)
        .map(|n| n.to_string())
        .collect();
    assert!(stops.contains(&samples) && samples != "100000", "{samples}");
    assert!(file.attribute("batch-render/time-limit").is_some());
}

#[test]
fn denoised_crops_are_refused_by_merge_for_what_they_are() {
    let folder = folder();
    for (name, crop) in [("a", "0,0,35,50"), ("b", "35,0,70,50")] {
        let file = format!("{name}.exr");
        folder.succeed(&words(&[
            "s.toml -q --integrator path --samples 4 --denoise --crop",
            crop,
            "-o",
            &file,
        ]));
    }
    let error = folder.fail(65, &["merge", "whole.exr", "a.exr", "b.exr"]);
    assert!(
        error.contains("the file is denoised: join the crops with noise, and denoise the whole: a.exr"),
        "{error}"
    );
    folder.succeed(&["merge", "whole.exr", "noisy/a.exr", "noisy/b.exr"]);
}

#[test]
fn the_progress_of_a_denoised_job_never_falls_and_ends_at_100() {
    let folder = folder();
    let progress = |more: &str| -> Vec<f64> {
        let said = folder.succeed(&words(&[JOB, "-r 1-4 --progress openjd", more]));
        let lines = said.lines().filter_map(|line| line.strip_prefix("openjd_progress: "));
        lines.map(|number| number.parse().expect("a number")).collect()
    };
    let whole = progress("-o f.#.exr");
    assert_eq!(whole, [12.5, 25.0, 37.5, 50.0, 62.5, 75.0, 87.5, 100.0]);
    assert_eq!(progress("-o f.#.exr --skip-existing"), [25.0, 50.0, 75.0, 100.0]);
    assert_eq!(progress("-o f.#.exr --denoise-step denoise"), [25.0, 50.0, 75.0, 100.0]);
}

#[test]
fn frames_beside_a_failed_one_are_denoised_and_made_anew_once_it_is_there() {
    let folder = folder();
    folder.succeed(&words(&[JOB, "-q -o whole/f.#.exr"]));
    fs::create_dir_all(folder.path("o/noisy")).expect("made");
    folder.write("o/noisy/f.2.exr", "");
    set_writable(&folder, "o/noisy/f.2.exr", false);
    let job = words(&[JOB, "-o o/f.#.exr --retries 0 --stats s.json"]);
    let output = folder.run(&job);
    let (said, message) = (String::from_utf8_lossy(&output.stdout).into_owned(), stderr(&output));
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("1 frame failed; 2 beside them were denoised without them"),
        "{message}"
    );
    assert!(
        message.contains("; to go on: ") && message.contains("--skip-existing") && !message.contains("--range"),
        "{message}"
    );
    assert!(said.ends_with("failed: 4 of 5 frames are on disk\n"), "{said}");
    let told = stats(&folder, "s.json");
    assert!(told["state"] == "failed" && told["is_finished"] == false);
    assert_eq!(
        names(&folder.path("o")),
        ["f.1.exr", "f.3.exr", "f.4.exr", "f.5.exr", "noisy"]
    );
    set_writable(&folder, "o/noisy/f.2.exr", true);
    folder.succeed(&[&job[..], &["--skip-existing"]].concat());
    let is_whole = |i: i32| folder.read(&format!("o/f.{i}.exr")) == folder.read(&format!("whole/f.{i}.exr"));
    assert!((1..=5).all(is_whole));
}

#[test]
fn a_denoised_file_that_cannot_be_written_is_the_failure_of_its_frame() {
    let folder = folder();
    folder.write("f.2.exr", "");
    set_writable(&folder, "f.2.exr", false);
    let job = words(&[JOB, "-q -o f.#.exr --retries 0"]);
    let message = folder.fail(1, &job);
    assert!(
        message.contains("frame 2: cannot create output: ") && message.contains("1 frame failed"),
        "{message}"
    );
    assert!(folder.path("f.5.exr").exists());
    folder.fail(73, &[&job[..], &["--range=2", "--denoise-step=denoise"]].concat());
}

#[test]
fn stale_and_missing_denoised_frames_are_listed_with_their_reasons() {
    let folder = folder();
    let job = words(&[JOB, "-o f.#.exr"]);
    let list = |more: &[&str]| folder.succeed(&[&job[..], &["--list-stale"], more].concat());
    assert_eq!(list(&[]).lines().next(), Some("1\tnoisy/f.1.exr\tis missing"));
    folder.succeed(&job);
    assert_eq!(list(&[]), "");
    let more =
        words(&["s.toml --frames p.csv --integrator path --set render.samples=8 --denoise -o f.#.exr --list-stale"]);
    assert_eq!(folder.succeed(&more).lines().count(), 5);
    fs::remove_file(folder.path("f.1.exr")).expect("it is there");
    folder.write("f.5.exr", "");
    assert_eq!(
        list(&[]),
        "1\tf.1.exr\tis missing\n5\tf.5.exr\tis incomplete or altered\n"
    );
    assert_eq!(list(&["--denoise-step=render"]), "");
    fs::remove_file(folder.path("noisy/f.3.exr")).expect("it is there");
    let reason = "was denoised with a frame that is rendered again";
    let expected = format!(
        "1\tf.1.exr\tis missing\n2\tf.2.exr\t{reason}\n3\tnoisy/f.3.exr\tis missing\n4\tf.4.exr\t{reason}\n5\tf.5.exr\tis incomplete or altered\n"
    );
    assert_eq!(list(&[]), expected);
}

#[test]
fn a_step_that_denoises_refuses_frames_of_other_settings_and_a_denoised_frame_stands_for_itself_alone() {
    let folder = folder();
    let job = words(&[JOB, "-o f.#.exr"]);
    let run = |more: &'static str| [&job[..], &words(&[more])].concat();
    folder.succeed(&run("--denoise-step=render"));
    folder.succeed(&run("--range=4 --seed=9 --denoise-step=render --overwrite"));
    let error = folder.fail(65, &run("--denoise-step=denoise"));
    let expected = "the file was rendered from other inputs or with other settings: render it again: noisy/f.4.exr";
    assert!(error.contains(expected), "{error}");
    // It helps no frame beside it.
    let output = folder.run(&run("--denoise-step=denoise --range=3,5"));
    assert!(
        output.status.success() && stderr(&output).contains(": 3,5 (without 4)"),
        "{}",
        stderr(&output)
    );
    // Frames 2 and 3 of three need the same files, and are not the same.
    let two_on_each_side = JOB.replace("--temporal 1", "--temporal 2");
    let three = words(&[&two_on_each_side, "--range 1-3 --skip-existing -o g.#.exr"]);
    folder.succeed(&three);
    let own = folder.read("g.2.exr");
    fs::copy(folder.path("g.3.exr"), folder.path("g.2.exr")).expect("it is there");
    folder.succeed(&three);
    assert!(folder.read("g.2.exr") == own);
}

#[test]
fn a_filter_whose_library_is_missing_ends_the_job_before_the_first_ray() {
    let folder = folder();
    let job = "s.toml -q --samples 4 --denoise oidn --oidn-lib nowhere.so -o o/f.exr";
    for more in ["--retries=0", "--check"] {
        let error = folder.fail(66, &words(&[job, more]));
        assert!(error.contains("--oidn-lib"), "{error}");
        assert!(!folder.path("o").exists());
    }
    folder.succeed(&words(&[job, "--denoise-step render --integrator path"]));
}

#[cfg(unix)]
#[test]
fn a_stopped_job_is_interrupted_in_its_figures_and_counts_denoised_frames() {
    let folder = folder();
    let job = "-r 1-3 --resolution 480x320 -o f.#.exr --stats s.json --report page --progress plain";
    let mut program = folder.program_with_signals();
    let child = program
        .args(words(&[JOB, job]))
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("it starts");
    let until = std::time::Instant::now() + std::time::Duration::from_secs(300);
    while !folder.path("f.1.exr").exists() {
        assert!(std::time::Instant::now() < until);
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let killed = std::process::Command::new("kill").arg(child.id().to_string()).status();
    assert!(killed.expect("kill starts").success());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(143));
    let there = (1..=3).filter(|i| folder.path(&format!("f.{i}.exr")).exists()).count();
    let told = stats(&folder, "s.json");
    assert!(told["state"] == "interrupted" && told["is_finished"] == false);
    assert_eq!(
        statuses(&told).iter().filter(|status| **status == "written").count(),
        there
    );
    let said = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(
        said.ends_with(&format!("interrupted: {there} of 3 frames are on disk\n")),
        "{said}"
    );
    let page = fs::read_to_string(folder.path("page/index.html")).expect("a page");
    assert!(
        page.contains(&format!("<p>interrupted: {there} frames written")),
        "{page}"
    );
}
