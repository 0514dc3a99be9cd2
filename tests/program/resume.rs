//! Resuming: which frames `--skip-existing` trusts, and what a killed job leaves.

use std::{
    fs,
    process::Stdio,
    thread::sleep,
    time::{Duration, Instant},
};

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE};

const JOB: [&str; 9] = [
    "s.toml",
    "--frames",
    "path.csv",
    "-o",
    "f.#.exr",
    "-o",
    "f.#.png",
    "--resolution",
    "16x12",
];

/// A rendered sequence of five frames.
fn rendered() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    folder.succeed(&JOB);
    folder
}

/// The frames that a job with these further arguments would render, with the reasons.
fn stale(folder: &Folder, more: &[&str]) -> Vec<(String, String)> {
    let said = folder.succeed(&[&JOB[..], &["--list-stale"], more].concat());
    let line = |line: &str| {
        let cells: Vec<&str> = line.split('\t').collect();
        (cells[0].to_owned(), cells[2].to_owned())
    };
    said.lines().map(line).collect()
}

/// The frames alone.
fn numbers(folder: &Folder, more: &[&str]) -> String {
    let frames: Vec<String> = stale(folder, more).into_iter().map(|(frame, _)| frame).collect();
    frames.join(" ")
}

const ALL: &str = "1 2 3 4 5";

#[test]
fn nothing_is_stale_after_a_job_whatever_the_dates_the_threads_and_the_place() {
    let folder = rendered();
    assert_eq!(numbers(&folder, &[]), "");
    // A list says what skipping would do, so both may be given, also where frames go to standard output.
    fs::remove_file(folder.path("f.3.png")).expect("it was there");
    assert_eq!(numbers(&folder, &["--skip-existing"]), "3");
    let stream = ["--skip-existing", "-o", "-", "--output-format", "png"];
    assert_eq!(numbers(&folder, &stream), "3");
    for refused in ["--overwrite", "--fail-existing"] {
        folder.fail(2, &[&JOB[..], &["--list-stale", refused]].concat());
    }
    folder.succeed(&JOB);
    assert_eq!(
        numbers(&folder, &["--threads", "1", "--accel", "bvh2", "--range", "2-4"]),
        ""
    );
    // The same inputs with new dates, at another place.
    folder.write("s.toml", SMALL_SCENE);
    let moved = Folder::new();
    for name in folder.names() {
        fs::copy(folder.path(&name), moved.path(&name)).expect("copied");
    }
    assert_eq!(numbers(&moved, &[]), "");
}

#[test]
fn every_setting_that_changes_pixels_makes_frames_stale() {
    let folder = rendered();
    for more in [
        &["--samples", "3"][..],
        &["--seed", "8"],
        &["--crop", "0,0,8,8"],
        &["--exposure", "1"],
        &["--view", "raw"],
        &["--integrator", "path"],
        &["--aovs", "depth"],
        &["--seed-mode", "fixed"],
    ] {
        assert_eq!(numbers(&folder, more), ALL, "{more:?}");
    }
    let (_, reason) = &stale(&folder, &["--seed", "8"])[0];
    assert_eq!(reason, "was rendered from other inputs or with other settings");
    folder.write("s.toml", &format!("{SMALL_SCENE}\n# a note\n"));
    assert_eq!(numbers(&folder, &[]), ALL);
}

#[test]
fn a_texture_that_is_painted_over_makes_frames_stale_and_its_date_does_not() {
    let folder = Folder::new();
    let textured = SMALL_SCENE.replace(
        "checker = { a = [0.9, 0.9, 0.9], b = [0.1, 0.1, 0.1], scale = 6 }",
        "image = { file = \"t.png\" }",
    );
    folder.write("s.toml", &textured);
    folder.write("path.csv", SMALL_PATH);
    let paint = |color: u8| {
        image::RgbImage::from_pixel(4, 4, image::Rgb([color; 3]))
            .save(folder.path("t.png"))
            .expect("written");
    };
    paint(200);
    folder.succeed(&JOB);
    paint(200);
    assert_eq!(numbers(&folder, &[]), "");
    // At half of its resolution it is another texture; with memory enough it is the same.
    assert_eq!(numbers(&folder, &["--texture-memory", "1M"]), "");
    assert_eq!(numbers(&folder, &["--texture-memory", "16B"]), ALL);
    paint(201);
    assert_eq!(numbers(&folder, &[]), ALL);
}

#[test]
fn a_key_that_moves_makes_the_frames_around_it_stale_alone() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let path = |x: f64| {
        let rows = (1..=5).map(|f| format!("{f},{},1,6,0,0.5,0\n", if f == 3 { x } else { 0.0 }));
        let head = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n".to_owned();
        folder.write("path.csv", &(head + &rows.collect::<String>()));
    };
    path(0.0);
    folder.succeed(&JOB);
    path(0.25);
    assert_eq!(numbers(&folder, &[]), "3");
    // Motion reaches to the frames beside it.
    let motion = &["--aovs", "forward,backward"][..];
    path(0.0);
    folder.succeed(&[&JOB[..], motion].concat());
    path(0.25);
    assert_eq!(numbers(&folder, motion), "2 3 4");
    path(0.0);
    folder.succeed(&JOB);
    path(0.25);
    let said = folder.succeed(&[&JOB[..], &["--skip-existing"]].concat());
    assert!(said.contains("1 frame rendered, 4 skipped in "), "{said}");
    assert!(
        said.contains("frame 3 is rendered again: f.3.exr was rendered from other inputs or with other settings"),
        "{said}"
    );
    assert_eq!(numbers(&folder, &[]), "");
}

#[test]
fn a_flipped_bit_a_cut_and_a_strange_file_are_found_and_mended() {
    let folder = rendered();
    let names = ["f.1.exr", "f.2.png"];
    let whole: Vec<Vec<u8>> = names.iter().map(|name| folder.read(name)).collect();
    for (name, whole) in names.iter().zip(&whole) {
        let frame = &name[2..3];
        // One of them in the name of the seal itself.
        let seal = whole.windows(8).position(|w| w == b"checksum").expect("it has a seal");
        for (step, at) in (0..25)
            .map(|step| step * (whole.len() - 1) / 24)
            .chain([seal])
            .enumerate()
        {
            let mut flipped = whole.clone();
            flipped[at] ^= 1 << (step % 8);
            fs::write(folder.path(name), &flipped).expect("writable");
            assert_eq!(numbers(&folder, &[]), frame, "{name}: bit of byte {at}");
            fs::write(folder.path(name), &whole[..at]).expect("writable");
            assert_eq!(numbers(&folder, &[]), frame, "{name}: {at} bytes");
        }
        fs::write(folder.path(name), whole).expect("writable");
    }
    // Both are cut by a byte.
    for (name, whole) in names.iter().zip(&whole) {
        fs::write(folder.path(name), &whole[1..]).expect("writable");
    }
    // The pictures of another frame and of another program.
    fs::copy(folder.path("f.4.exr"), folder.path("f.5.exr")).expect("copied");
    image::RgbImage::new(16, 12)
        .save(folder.path("f.3.png"))
        .expect("written");
    let reasons: Vec<String> = stale(&folder, &[]).into_iter().map(|(_, reason)| reason).collect();
    assert_eq!(
        reasons,
        [
            "is incomplete or altered",
            "is incomplete or altered",
            "was not written by this version of batch-render",
            "was rendered from other inputs or with other settings",
        ]
    );
    folder.succeed(&[&JOB[..], &["--skip-existing"]].concat());
    assert_eq!(numbers(&folder, &[]), "");
    for (name, whole) in names.iter().zip(&whole) {
        assert!(folder.read(name) == *whole, "{name}");
    }
}

#[test]
fn figures_tell_what_became_of_each_frame() {
    let folder = rendered();
    fs::remove_file(folder.path("f.2.png")).expect("removed");
    folder.write("f.4.exr", "no picture");
    folder.succeed(&[&JOB[..], &["--skip-existing", "--stats", "stats.json"]].concat());
    let stats: serde_json::Value = serde_json::from_slice(&folder.read("stats.json")).expect("JSON");
    assert_eq!(
        (stats["total"].as_u64(), stats["is_finished"].as_bool()),
        (Some(5), Some(true))
    );
    let frames = stats["frames"].as_array().expect("a list");
    let status: Vec<_> = frames
        .iter()
        .map(|frame| frame["status"].as_str().expect("a text"))
        .collect();
    assert_eq!(status, ["skipped", "written", "skipped", "written", "skipped"]);
    let fourth = &frames[3];
    assert_eq!(fourth["reason"], "f.4.exr is incomplete or altered");
    assert_eq!(fourth["samples"].as_u64(), Some(16 * 12 * 20));
    assert!(fourth["segments"].as_u64() >= Some(16 * 12 * 20) && fourth["shadow_rays"].as_u64() > Some(0));
    assert_eq!(fourth["files"], serde_json::json!(["f.4.exr", "f.4.png"]));
    assert_eq!(fourth["fingerprint"].as_str().map(str::len), Some(32));
    // A later run keeps what this one tells of frames that it skips.
    fs::remove_file(folder.path("f.1.png")).expect("removed");
    folder.succeed(&[&JOB[..], &["--skip-existing", "--stats", "stats.json"]].concat());
    let later: serde_json::Value = serde_json::from_slice(&folder.read("stats.json")).expect("JSON");
    assert_eq!(later["frames"][3], *fourth);
    assert_eq!(later["frames"][0]["status"], "written");

    folder.succeed(&[&JOB[..], &["--range=2-5", "--report", "page"]].concat());
    assert_eq!(
        crate::common::names(&folder.path("page")),
        ["figures.json", "index.html"]
    );
    let page = String::from_utf8(folder.read("page/index.html")).expect("UTF-8");
    assert!(
        page.contains("finished: 4 frames written, 0 skipped, 0 failed, of 4; "),
        "{page}"
    );
    assert_eq!(page.matches("<img src=\"data:image/png;base64,").count(), 4);
    assert!(
        page.contains("<h2>Slowest frames</h2>") && page.contains("--report page"),
        "{page}"
    );
    assert!(!page.contains("http://") && !page.contains("https://"));
}

#[test]
fn parts_render_every_frame_once_and_the_same_bytes() {
    let folder = rendered();
    let parts = Folder::new();
    parts.write("s.toml", SMALL_SCENE);
    parts.write("path.csv", SMALL_PATH);
    for (part, count) in [("0/3", 1), ("1/3", 2), ("2/3", 2)] {
        let said = parts.succeed(&[&JOB[..], &["--part", part, "--part-base", "0"]].concat());
        let frames = format!("{count} frame{} rendered in", if count == 1 { "" } else { "s" });
        assert!(said.contains(&frames), "{part}: {said}");
    }
    for name in folder.names() {
        assert!(folder.read(&name) == parts.read(&name), "{name}");
    }
    // What lies beside the pictures is that of the whole job, whichever part comes last.
    parts.succeed(&[&JOB[..], &["--part", "2/3", "--metadata", "transforms"]].concat());
    let transforms: serde_json::Value = serde_json::from_slice(&parts.read("transforms.json")).expect("JSON");
    assert_eq!(transforms["frames"].as_array().map(Vec::len), Some(5));
    let message = parts.fail(2, &[&JOB[..], &["--part", "4/3"]].concat());
    assert!(message.contains("parts are numbered from 1 to 3"), "{message}");
}

#[test]
fn a_key_that_is_set_renders_anew_what_it_changes() {
    let folder = rendered();
    assert_eq!(numbers(&folder, &["--set", "background.color=[1, 0, 0]"]), ALL);
    assert_eq!(numbers(&folder, &["--set", "render.working_space=acescg"]), ALL);
    let seed = numbers(&folder, &["--set", "render.seed=9"]);
    assert_eq!(
        (seed, numbers(&folder, &["--seed", "9"])),
        (ALL.to_owned(), ALL.to_owned())
    );
    let error = folder.fail(2, &[&JOB[..], &["--set", "render.sed=9"]].concat());
    assert!(
        error.contains("--set render.sed: unknown key `sed` (did you mean `seed`?)"),
        "{error}"
    );
    let error = folder.fail(2, &[&JOB[..], &["--set", "seed"]].concat());
    assert!(error.contains("expected NAME=VALUE"), "{error}");
}

#[test]
fn files_beside_the_pictures_are_mended_though_all_frames_are_there() {
    let folder = rendered();
    let job = [&JOB[..], &["--metadata", "transforms,ids", "--skip-existing"]].concat();
    folder.succeed(&job);
    let whole = ["transforms.json", "ids.json"].map(|name| folder.read(name));
    fs::write(folder.path("transforms.json"), &whole[0][..20]).expect("written");
    fs::write(folder.path("ids.json"), "{}").expect("written");
    let said = folder.succeed(&job);
    assert!(said.contains("0 frames rendered, 5 skipped in "), "{said}");
    assert!(whole == ["transforms.json", "ids.json"].map(|name| folder.read(name)));
}

#[cfg(unix)]
#[test]
fn a_frame_that_cannot_be_written_does_not_keep_the_others_from_it() {
    use std::os::unix::fs::PermissionsExt;
    let folder = rendered();
    let closed = folder.path("f.3.png");
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o444)).expect("set");
    let before = folder.read("f.3.png");
    let job = [&JOB[..], &["--seed", "9", "--retries", "0"]].concat();
    let message = folder.fail(1, &job);
    assert!(message.contains("frame 3: cannot create output: "), "{message}");
    assert!(
        message.contains("to repeat it alone: ") && message.contains("--range=3"),
        "{message}"
    );
    assert!(message.contains("1 frame failed"), "{message}");
    assert!(folder.read("f.3.png") == before);
    assert_eq!(numbers(&folder, &["--seed", "9"]), "3");
    // One cause for all that was tried.
    folder.fail(73, &[&job[..], &["--range=3"]].concat());
    folder.fail(73, &[&job[..], &["--fail-fast"]].concat());
}

#[cfg(unix)]
#[test]
fn a_file_that_may_not_be_replaced_fails_its_frame_alone_without_another_attempt_also_the_first() {
    use std::os::unix::fs::PermissionsExt;
    let folder = rendered();
    let set = |name: &str, mode| {
        fs::set_permissions(folder.path(name), fs::Permissions::from_mode(mode)).expect("set");
    };
    let job = [&JOB[..], &["--seed", "9"]].concat();
    for closed in [1, 3] {
        let name = format!("f.{closed}.png");
        set(&name, 0o444);
        let before = folder.read(&name);
        let message = folder.fail(1, &job);
        assert!(
            message.starts_with(&format!(
                "error: frame {closed}: cannot create output: permission denied: {name}; "
            )),
            "{message}"
        );
        assert!(message.ends_with("error: 1 frame failed\n"), "{message}");
        assert!(!message.contains("attempt"), "{message}");
        assert!(folder.read(&name) == before);
        assert_eq!(numbers(&folder, &["--seed", "9"]), closed.to_string());
        set(&name, 0o644);
        folder.succeed(&JOB);
    }
}

#[cfg(unix)]
#[test]
fn a_folder_that_closes_or_vanishes_ends_the_job_with_the_code_of_such_outputs() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let close = |out: &std::path::Path| fs::set_permissions(out, fs::Permissions::from_mode(0o555)).expect("set");
    let vanish = |out: &std::path::Path| fs::rename(out, out.with_extension("gone")).expect("renamed");
    for (name, change) in [("closed", &close as &dyn Fn(&std::path::Path)), ("vanished", &vanish)] {
        let out = folder.path(name);
        let mut program = folder.program();
        program.args(["s.toml", "--turntable", "500", "--resolution", "64x48", "-o"]);
        let child = program
            .arg(format!("{name}/f.###.png"))
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let child = child.spawn().expect("it starts");
        let start = Instant::now();
        while !out.join("f.001.png").exists() {
            assert!(start.elapsed() < Duration::from_secs(60), "no frame");
            sleep(Duration::from_millis(5));
        }
        change(&out);
        let output = child.wait_with_output().expect("it ends");
        let message = crate::common::stderr(&output);
        assert_eq!(output.status.code(), Some(73), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(message.starts_with("error: cannot create output: "), "{message}");
        if out.exists() {
            fs::set_permissions(&out, fs::Permissions::from_mode(0o755)).expect("set");
        }
    }
}

/// Starts a job of many frames again and again and kills it after a while that differs each time, until `kills` were killed;
/// then lets it end. All files are then those of a job that nobody killed.
fn killed(kills: u32) {
    let whole = Folder::new();
    let folder = Folder::new();
    for home in [&whole, &folder] {
        home.write("s.toml", SMALL_SCENE);
    }
    let job = [
        "s.toml",
        "--turntable",
        "20",
        "-o",
        "f.##.exr",
        "-o",
        "f.##.png",
        "-o",
        "f.##.npz",
        "--skip-existing",
    ];
    let job = [
        &job[..],
        &["--resolution", "48x36", "--samples", "16", "--progress", "none"],
    ]
    .concat();
    let start = Instant::now();
    whole.succeed(&job);
    let duration = start.elapsed();
    for kill in 0..kills {
        let mut child = folder
            .program()
            .args(&job)
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        // From at once to the whole duration, in no order.
        sleep(duration * (kill * 7919 % 1000) / 1000);
        child.kill().expect("killed");
        child.wait().expect("ended");
        if kill % 4 == 3 {
            // What is there may be wrong by then.
            let _ = fs::remove_file(folder.path(&format!("f.{:02}.exr", kill % 20 + 1)));
        }
    }
    folder.succeed(&job);
    assert_eq!(folder.names(), whole.names());
    for name in whole.names() {
        assert!(folder.read(&name) == whole.read(&name), "{name}");
    }
}

#[test]
fn a_sequence_that_is_killed_again_and_again_ends_as_if_nobody_had() {
    killed(12);
}

/// Takes some minutes.
#[test]
#[ignore = "long"]
fn a_sequence_that_is_killed_200_times_ends_as_if_nobody_had() {
    killed(200);
}

/// The bars: 10,000 finished frames of 64 x 64 in 10 s.
#[test]
#[ignore = "long"]
fn ten_thousand_finished_frames_are_skipped_in_ten_seconds() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let job = ["s.toml", "--turntable", "10000", "-o", "f/#.exr", "--skip-existing"];
    let job = [
        &job[..],
        &["--resolution", "64x64", "--samples", "1", "--progress", "none"],
    ]
    .concat();
    folder.succeed(&job);
    let start = Instant::now();
    folder.succeed(&job);
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
}
