//! Frames that are interrupted: cut short by a limit of time, kept and gone on from, shown as they stand; and jobs that meet.

use std::{
    fs,
    process::{Child, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

use crate::common::{Folder, SMALL_SCENE};

const PASSES: &str = "depth,N,albedo,variance,sampleCount,CryptoObject,diffuse_direct,lightgroup";

/// One frame of all kinds of sums.
const JOB: [&str; 9] = [
    "s.toml",
    "-o",
    "f.exr",
    "-o",
    "f.png",
    "--aovs",
    PASSES,
    "--progress",
    "none",
];

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder
}

fn start(folder: &Folder, args: &[&str]) -> Child {
    let mut program = folder.program_with_signals();
    program
        .args(args)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

#[cfg(unix)]
fn signal(child: &Child, name: &str) {
    let status = std::process::Command::new("kill")
        .args([&format!("-{name}"), &child.id().to_string()])
        .status();
    assert!(status.expect("kill runs").success());
}

fn stderr_of(child: Child) -> (Option<i32>, String) {
    let output = child.wait_with_output().expect("it ends");
    (output.status.code(), crate::common::stderr(&output))
}

/// The samples of the pixels of `f.exr`, which are the same for all.
fn samples(folder: &Folder) -> f32 {
    let image = folder.open_exr("f.exr");
    let channels = image.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
    let counts = channels
        .into_iter()
        .find(|c| c.name.to_string().starts_with("sampleCount"));
    let mut counts = counts.expect("a pass").sample_data.values_as_f32();
    let first = counts.next().expect("a pixel");
    assert!(counts.all(|count| count == first));
    first
}

#[test]
fn a_time_limit_gives_every_pixel_as_many_samples_as_fit_and_says_how_many() {
    let folder = folder();
    let job = [
        &JOB[..],
        &["--samples", "10000000", "--time-limit", "0.5s", "--stats", "st.json"],
    ]
    .concat();
    let begin = Instant::now();
    let output = folder.run(&job);
    assert!(output.status.success());
    assert!(begin.elapsed() < Duration::from_secs(20), "{:?}", begin.elapsed());
    let got = samples(&folder);
    assert!((1.0..1e6).contains(&got), "{got}");
    let message = crate::common::stderr(&output);
    let told = format!("frame 1 has {got} of 10000000 samples, the time limit is over");
    assert!(message.contains(&told), "{message}");
    let stats: serde_json::Value = serde_json::from_slice(&folder.read("st.json")).expect("JSON");
    assert_eq!(stats["frames"][0]["samples_per_pixel"].as_f64(), Some(f64::from(got)));
    // For a limit that is not longer it is finished.
    let stale = |more: &[&str]| folder.succeed(&[&JOB[..], &["--samples", "10000000", "--list-stale"], more].concat());
    assert_eq!(stale(&["--time-limit", "0.5s"]), "");
    assert_eq!(stale(&["--time-limit", "0.4s"]), "");
    for more in [&["--time-limit", "1m"][..], &[]] {
        assert_eq!(stale(more), "1\tf.exr\twas cut short by a shorter time limit\n");
    }
}

#[test]
fn a_time_limit_that_is_long_enough_changes_no_bit() {
    let (limited, whole) = (folder(), folder());
    limited.succeed(&[&JOB[..], &["--time-limit", "1h"]].concat());
    whole.succeed(&JOB);
    for name in ["f.exr", "f.png"] {
        assert!(limited.read(name) == whole.read(name), "{name}");
    }
}

#[test]
fn passes_by_halves_of_the_samples_are_the_same_with_a_time_limit_that_is_long_enough() {
    let (free, limited) = (folder(), folder());
    for passes in ["denoise", "all"] {
        let job = [&JOB[..], &["--aovs", passes]].concat();
        free.succeed(&job);
        limited.succeed(&[&job[..], &["--time-limit", "1h"]].concat());
        let names = free.names();
        assert!(names.iter().any(|name| name.ends_with(".exr")), "{names:?}");
        assert!(
            names.iter().all(|name| free.read(name) == limited.read(name)),
            "{passes}"
        );
    }
}

/// The job with so many samples that it takes a while.
fn long<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&JOB[..], &["--samples", "400"], more].concat()
}

#[test]
fn a_frame_that_is_killed_again_and_again_goes_on_with_the_same_bits() {
    let (whole, folder) = (folder(), folder());
    let begin = Instant::now();
    whole.succeed(&long(&[]));
    let duration = begin.elapsed();
    let mut has_gone_on = false;
    for kill in 0_u32..12 {
        let threads = ["1", "2", "3"][kill as usize % 3];
        let mut child = start(&folder, &long(&["--checkpoint", "0.05s", "--threads", threads, "-v"]));
        sleep(duration * (kill * 7919 % 1000) / 1000);
        let _ = child.kill();
        has_gone_on |= stderr_of(child).1.contains("frame 1 goes on from f.exr.checkpoint");
    }
    assert!(has_gone_on);
    folder.succeed(&long(&["--checkpoint", "1h"]));
    assert_eq!(folder.names(), whole.names());
    for name in ["f.exr", "f.png"] {
        assert!(folder.read(name) == whole.read(name), "{name}");
    }
}

#[test]
fn an_adaptive_frame_that_is_killed_goes_on_with_the_same_bits() {
    let (whole, folder) = (folder(), folder());
    let adaptive = |more: &[&'static str]| {
        let rule = [
            "--samples",
            "512",
            "--noise-threshold",
            "0.004",
            "--aovs",
            "denoise,sampleCount",
        ];
        [&JOB[..5], &rule, more].concat()
    };
    let begin = Instant::now();
    whole.succeed(&adaptive(&[]));
    let duration = begin.elapsed();
    let mut has_gone_on = false;
    for kill in 0_u32..6 {
        let threads = ["1", "2", "3"][kill as usize % 3];
        let mut child = start(
            &folder,
            &adaptive(&["--checkpoint", "0.05s", "--threads", threads, "-v"]),
        );
        sleep(duration * (kill * 7919 % 1000) / 1000);
        let _ = child.kill();
        has_gone_on |= stderr_of(child).1.contains("frame 1 goes on from f.exr.checkpoint");
    }
    assert!(has_gone_on);
    folder.succeed(&adaptive(&["--checkpoint", "1h"]));
    for name in ["f.exr", "f.png"] {
        assert!(folder.read(name) == whole.read(name), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn sigterm_keeps_the_frame_where_checkpoints_are_asked_for() {
    let (whole, folder) = (folder(), folder());
    let begin = Instant::now();
    whole.succeed(&long(&[]));
    let duration = begin.elapsed();
    let child = start(&folder, &long(&["--checkpoint", "1h"]));
    sleep(duration / 2);
    let begin = Instant::now();
    signal(&child, "TERM");
    assert_eq!(stderr_of(child).0, Some(143));
    assert!(begin.elapsed() < Duration::from_millis(500), "{:?}", begin.elapsed());
    assert_eq!(folder.names(), ["f.exr.checkpoint", "s.toml"]);
    // Another picture does not go on from it, and a damaged one is not used.
    let message = folder.run(&[&JOB[..], &["--checkpoint", "1h", "--samples", "1"]].concat());
    assert!(
        crate::common::stderr(&message).contains("not used, for it is damaged or of other settings: f.exr.checkpoint")
    );
    let child = start(&folder, &long(&["--checkpoint", "1h"]));
    sleep(duration / 2);
    signal(&child, "INT");
    assert_eq!(stderr_of(child).0, Some(130));
    folder.succeed(&long(&["--checkpoint", "1h"]));
    assert!(folder.read("f.exr") == whole.read("f.exr"));
    assert!(!folder.path("f.exr.checkpoint").exists());
}

#[cfg(unix)]
#[test]
fn sigusr1_shows_the_frame_as_it_stands_and_changes_no_bit() {
    let (whole, folder) = (folder(), folder());
    let begin = Instant::now();
    whole.succeed(&long(&[]));
    let duration = begin.elapsed();
    for more in [&[][..], &["--checkpoint", "1h"]] {
        let child = start(&folder, &long(more));
        sleep(duration / 2);
        signal(&child, "USR1");
        let (code, message) = stderr_of(child);
        assert_eq!(code, Some(0), "{message}");
        assert!(message.contains("frame 1 as it stands: f.partial.exr"), "{message}");
        let (width, pixels) = crate::common::pixels(&folder.path("f.partial.exr"));
        assert_eq!((width, pixels.len()), (70, 70 * 50));
        assert!(pixels.iter().flatten().all(|value| value.is_finite()));
        assert!(folder.read("f.exr") == whole.read("f.exr"));
        fs::remove_file(folder.path("f.partial.exr")).expect("removed");
    }
}

#[test]
fn the_second_job_of_the_same_files_waits_or_leaves_and_one_of_other_files_does_neither() {
    let folder = folder();
    let first = start(&folder, &long(&[]));
    let begin = Instant::now();
    while !folder.names().iter().any(|name| name.ends_with(".job.tmp")) {
        assert!(begin.elapsed() < Duration::from_secs(30));
        sleep(Duration::from_millis(5));
    }
    let message = folder.fail(75, &long(&["--if-busy", "leave"]));
    assert!(
        message.contains("another job (process ") && message.contains("writes ./f.exr"),
        "{message}"
    );
    folder.succeed(&["s.toml", "-o", "g.exr", "--if-busy", "leave", "--samples", "1"]);
    let second = folder.run(&long(&["--skip-existing"]));
    let said = crate::common::stderr(&second);
    assert!(
        second.status.success() && said.contains("this one waits until that has ended"),
        "{said}"
    );
    assert_eq!(stderr_of(first).0, Some(0));
    assert_eq!(folder.names(), ["f.exr", "f.png", "g.exr", "s.toml"]);
    // A job that was killed keeps nobody waiting.
    let mut killed = start(&folder, &long(&[]));
    while !folder.names().iter().any(|name| name.ends_with(".job.tmp")) {
        sleep(Duration::from_millis(5));
    }
    killed.kill().expect("killed");
    killed.wait().expect("ended");
    folder.succeed(&long(&["--if-busy", "leave", "--skip-existing"]));
    assert_eq!(folder.names(), ["f.exr", "f.png", "g.exr", "s.toml"]);
}
