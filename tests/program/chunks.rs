//! Files of a whole sequence that several jobs render: none loses what the others wrote.

use std::{
    fs,
    process::{Child, Stdio},
    thread::sleep,
    time::Duration,
};

use serde_json::{Value, json};

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE, stderr};

const JOB: [&str; 12] = [
    "s.toml",
    "--frames",
    "path.csv",
    "--samples",
    "2",
    "--progress",
    "none",
    "-o",
    "out/f.####.png",
    "--metadata",
    "transforms,ids",
    "--threads=1",
];

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    folder
}

fn whole() -> Folder {
    let folder = folder();
    folder.succeed(&JOB);
    folder
}

fn assert_same(folder: &Folder, whole: &Folder) {
    for name in ["out/transforms.json", "out/ids.json"] {
        let [own, expected] = [folder, whole].map(|f| String::from_utf8(f.read(name)).expect("UTF-8"));
        assert_eq!(own, expected, "{name}");
    }
}

fn start(folder: &Folder, args: &[&str]) -> Child {
    let mut program = folder.program();
    program.args(JOB).args(args).stderr(Stdio::null());
    program.spawn().expect("the program starts")
}

/// The numbers of the frames of a file of cameras or figures.
fn frames(folder: &Folder, name: &str) -> Vec<i64> {
    let file: Value = serde_json::from_slice(&folder.read(name)).expect("JSON");
    let frames = file["frames"].as_array().expect("a list").iter();
    frames.map(|frame| frame["frame"].as_i64().expect("a number")).collect()
}

#[test]
fn ranges_one_after_the_other_leave_the_files_of_the_whole_job() {
    let (whole, folder) = (whole(), folder());
    for range in ["4", "1-2", "5,3", "2-4"] {
        folder.succeed(&[&JOB[..], &["--range", range]].concat());
    }
    assert_same(&folder, &whole);
    // A part of a range is one, too; and the whole job replaces the file.
    folder.succeed(&[&JOB[..], &["--range", "2-5", "--part", "2/2"]].concat());
    assert_same(&folder, &whole);
    folder.write("path.csv", &SMALL_PATH.replace("\n5,", "\n3,"));
    folder.succeed(&JOB);
    assert_eq!(frames(&folder, "out/transforms.json"), [1, 2, 3]);
}

#[test]
fn jobs_that_end_at_once_lose_no_frame() {
    let whole = whole();
    for _ in 0..3 {
        let folder = folder();
        let jobs = ["1", "2", "3", "4", "5"].map(|range| start(&folder, &["--range", range]));
        for mut job in jobs {
            assert!(job.wait().expect("ended").success());
        }
        assert_same(&folder, &whole);
    }
}

#[test]
fn a_job_that_is_killed_leaves_whole_files_and_its_frames_come_with_the_next() {
    let (whole, folder) = (whole(), folder());
    for kill in 0..8 {
        let mut killed = start(&folder, &["--range", "1-3"]);
        let mut other = start(&folder, &["--range", "4-5"]);
        sleep(Duration::from_millis(15 * kill));
        killed.kill().expect("killed");
        killed.wait().expect("ended");
        assert!(other.wait().expect("ended").success());
        let there = frames(&folder, "out/transforms.json");
        assert!(there == [4, 5] || there == [1, 2, 3, 4, 5], "{there:?}");
    }
    folder.succeed(&[&JOB[..], &["--range", "1-3", "--skip-existing"]].concat());
    assert_same(&folder, &whole);
}

#[test]
fn frames_of_other_pictures_are_not_joined() {
    let folder = folder();
    let cameras = "out/transforms.json";
    let render = |range: &str, files: &str, args: &[&str]| {
        let job = ["--range", range, "-o", files];
        let output = folder.run(&[&JOB[..7], &JOB[9..], &job, args].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        (frames(&folder, cameras), stderr(&output))
    };
    assert_eq!(render("1-2", "out/f.####.png", &[]).0, [1, 2]);
    // Pictures of another size, of another name, and of one name for all.
    let crop = ["--crop", "0,0,20,20"];
    assert_eq!(render("3", "out/f.####.png", &crop).0, [3]);
    assert_eq!(render("4", "out/g.####.png", &crop).0, [4]);
    assert_eq!(render("5", "out/g.png", &crop).0, [5]);
    assert_eq!(render("4", "out/g.png", &crop).0, [4]);
    folder.write(cameras, "{}");
    let (there, message) = render("2", "out/f.####.png", &[]);
    assert_eq!(there, [2]);
    assert!(
        message.contains("the frames of other jobs are lost, missing field"),
        "{message}"
    );
}

#[test]
fn a_part_lists_pictures_of_other_parts_as_far_as_they_are_those_of_its_job() {
    let folder = folder();
    let job = |more: &str| {
        let more: Vec<&str> = more.split_whitespace().collect();
        folder.succeed(&[&JOB[..3], &JOB[5..9], &more].concat());
    };
    let listed = |more: &str| {
        fs::remove_file(folder.path("out/transforms.json")).ok();
        job(&format!(
            "{more} --resolution 14x10 --samples 2 --part 2/2 --metadata transforms"
        ));
        frames(&folder, "out/transforms.json")
    };
    // Pictures of another size, of another seed, and of this job.
    for other in ["--resolution 7x5", "--resolution 14x10 --seed 3"] {
        job(&format!("{other} --samples 2 --part 1/2"));
        assert_eq!(listed(""), [3, 4, 5], "{other}");
    }
    job("--resolution 14x10 --samples 2 --part 1/2");
    assert_eq!(listed(""), [1, 2, 3, 4, 5]);
    // Denoised ones, too.
    let denoised = "--integrator path --denoise";
    job(&format!("{denoised} --resolution 7x5 --samples 2"));
    assert_eq!(listed(&format!("{denoised} --denoise-step render")), [3, 4, 5]);
    job(&format!("{denoised} --resolution 14x10 --samples 2"));
    assert_eq!(listed(&format!("{denoised} --denoise-step render")), [1, 2, 3, 4, 5]);
}

#[test]
fn figures_of_other_crops_and_seeds_do_not_count() {
    let folder = folder();
    let small = ["--resolution", "14x10", "--stats", "stats.json"];
    let job = |more: &[&str]| stderr(&folder.run(&[&JOB[..], &small, more].concat()));
    job(&["--range", "1-3"]);
    for other in [["--crop", "0,0,7,5"], ["--seed", "5"]] {
        let said = job(&[&["--range", "3-4"], &other[..]].concat());
        assert!(
            said.contains("the figures of other jobs are lost, they are of other inputs"),
            "{said}"
        );
        let stats: Value = serde_json::from_slice(&folder.read("stats.json")).expect("JSON");
        assert_eq!(frames(&folder, "stats.json"), [3, 4]);
        assert_eq!(stats["total"], 2);
    }
    // Frames beyond the sequence are no longer its own.
    job(&["--overwrite"]);
    folder.write("path.csv", &SMALL_PATH.replace("\n5,", "\n3,"));
    job(&["--skip-existing"]);
    assert_eq!(frames(&folder, "stats.json"), [1, 2, 3]);
}

#[test]
fn files_beside_denoised_pictures_name_those() {
    let folder = folder();
    let job = [
        "s.toml",
        "--samples",
        "2",
        "--progress",
        "none",
        "--metadata",
        "transforms",
        "--denoise",
        "-o",
        "f.exr",
    ];
    folder.succeed(&job);
    let file: Value = serde_json::from_slice(&folder.read("transforms.json")).expect("JSON");
    assert_eq!(file["frames"][0]["file_path"], "f.exr");
    // A PNG file of numbers is no picture.
    folder.succeed(&[&job[..7], &["-o", "g.exr", "--png-depth"]].concat());
    let file: Value = serde_json::from_slice(&folder.read("transforms.json")).expect("JSON");
    assert_eq!(file["frames"][0]["file_path"], "g.exr");
}

#[test]
fn figures_reports_and_previews_of_parts_have_the_frames_of_all() {
    let folder = folder();
    let files = ["--stats", "stats.json", "--report", "page", "--preview", "film.png"];
    let mut jobs = ["1/2", "2/2"].map(|part| start(&folder, &[&files[..], &["--part", part]].concat()));
    jobs.iter_mut()
        .for_each(|job| assert!(job.wait().expect("ended").success()));
    let stats: Value = serde_json::from_slice(&folder.read("stats.json")).expect("JSON");
    let told = stats["frames"].as_array().expect("a list");
    let words: Vec<_> = told.iter().map(|frame| [&frame["frame"], &frame["status"]]).collect();
    assert_eq!(
        json!(words),
        json!([
            [1, "written"],
            [2, "written"],
            [3, "written"],
            [4, "written"],
            [5, "written"]
        ])
    );
    assert_eq!(
        (stats["total"].as_u64(), stats["is_finished"].as_bool()),
        (Some(5), Some(true))
    );
    let page = || String::from_utf8(folder.read("page/index.html")).expect("UTF-8");
    assert_eq!(page().matches("<img").count(), 5);
    assert!(
        page().contains("5 frames written, 0 skipped, 0 failed, of 5"),
        "{}",
        page()
    );
    let film = png::Decoder::new(std::io::Cursor::new(folder.read("film.png")))
        .read_info()
        .expect("a PNG");
    assert_eq!(film.info().animation_control.expect("it is animated").num_frames, 5);

    // A frame that is repaired replaces its own figures alone, and one that is there keeps them.
    folder.succeed(&[&JOB[..], &files, &["--range", "3", "--resolution", "35x25"]].concat());
    assert_eq!(
        frames(&folder, "stats.json"),
        [3],
        "other settings are another sequence"
    );
    let small = [&JOB[..], &files[..4], &["--resolution", "35x25"]].concat();
    folder.succeed(&[&small[..], &["--range", "1-2"]].concat());
    folder.succeed(&[&small[..], &["--range", "1-4", "--skip-existing"]].concat());
    let stats: Value = serde_json::from_slice(&folder.read("stats.json")).expect("JSON");
    let words: Vec<_> = stats["frames"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|f| &f["status"])
        .collect();
    assert_eq!(json!(words), json!(["written", "written", "written", "written"]));
    assert!(stats["frames"][0]["wall_s"].as_f64() > Some(0.0));
    assert_eq!(page().matches("<img").count(), 4);
}

#[cfg(unix)]
#[test]
fn figures_in_the_place_of_a_pipe_are_refused_at_once() {
    let folder = Folder::new();
    folder.write(
        "s.toml",
        "[camera]\nperspective = { eye = [0, 0, 5], target = [0, 0, 0] }\n",
    );
    let made = std::process::Command::new("mkfifo").arg(folder.path("pipe")).status();
    assert!(made.expect("mkfifo runs").success());
    for chunk in [&[][..], &["--range", "1"]] {
        let job = [
            "s.toml",
            "--resolution",
            "4x4",
            "--samples",
            "1",
            "-o",
            "f.png",
            "--stats",
            "pipe",
        ];
        folder.fail(73, &[&job[..], chunk].concat());
    }
}

/// A job over the frames of a path whose lens is bent in the last frame alone.
fn folder_of_bent_lens() -> Folder {
    let folder = Folder::new();
    let lens =
        "perspective = { eye = [0, 2, 6], target = [0, 0.8, 0], fov = 40, aperture_radius = 0.05, focus_distance = 6 }";
    let pinhole = "pinhole = { eye = [0, 2, 6], target = [0, 0.8, 0], fx = 70 }";
    let scene = SMALL_SCENE.replace(lens, pinhole);
    assert!(scene.contains(pinhole), "the lens of the scene");
    folder.write("s.toml", &scene);
    let head = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,k1\n";
    let rows = "1,0,2,6,0,0.8,0,0\n2,1,2,6,0,0.8,0,0\n3,2,2,5,0,0.8,0,0.1\n";
    folder.write("path.csv", &format!("{head}{rows}"));
    folder
}

#[test]
fn parts_of_a_path_whose_lens_changes_write_the_pictures_and_cameras_of_the_whole_job() {
    let whole = folder_of_bent_lens();
    whole.succeed(&JOB);
    let file: Value = serde_json::from_slice(&whole.read("out/transforms.json")).expect("JSON");
    assert_eq!(file["camera_model"], "OPENCV");
    for parts in [
        ["--range=1-2", "--range=3"],
        ["--range=3", "--range=1-2"],
        ["--part=1/2", "--part=2/2"],
    ] {
        let folder = folder_of_bent_lens();
        for part in parts {
            let said = folder.succeed(&[&JOB[..], &[part]].concat());
            assert!(!said.contains("warning"), "{said}");
        }
        assert_same(&folder, &whole);
        for frame in 1..=3 {
            let name = format!("out/f.{frame:04}.png");
            assert!(folder.read(&name) == whole.read(&name), "{name}");
        }
    }
}

#[test]
fn a_job_that_ends_at_a_failed_frame_lists_no_frame_that_it_did_not_render() {
    let folder = folder();
    let scene = format!(
        "{SMALL_SCENE}[[object]]\nname = \"box\"\nmaterial = \"red\"\nshape.cuboid = {{ min = [0, 0, 0], max = [1, 1, 1] }}\n"
    );
    folder.write("s.toml", &scene);
    // A box of frame 3 has no size.
    folder.write(
        "v.csv",
        "frame,object.box.shape.cuboid.max.x\n1,1\n2,1\n3,-1\n4,1\n5,1\n",
    );
    let job = [&JOB[..], &["--values", "v.csv"]].concat();
    folder.fail(65, &[&job[..], &["--range", "3"]].concat());
    folder.fail(1, &[&job[..], &["--fail-fast"]].concat());
    assert_eq!(frames(&folder, "out/transforms.json"), [1, 2]);
    folder.fail(1, &job);
    assert_eq!(frames(&folder, "out/transforms.json"), [1, 2, 4, 5]);
    // All that was tried has failed, but the other frames are there.
    folder.fail(1, &[&job[..], &["--skip-existing"]].concat());
    assert_eq!(frames(&folder, "out/transforms.json"), [1, 2, 4, 5]);
}

#[test]
fn cameras_of_two_models_are_refused_before_the_first_ray() {
    let folder = folder();
    let camera = |frame: u32, model: &str| {
        json!({ "frame": frame, "camera_model": model, "fl_x": 70, "w": 70, "h": 50, "k1": 0.01,
            "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 1], [0, 0, 1, 6], [0, 0, 0, 1]] })
    };
    let job = [&["s.toml", "--frames", "c.json"], &JOB[3..]].concat();
    for (other, is_common) in [("PINHOLE", true), ("OPENCV_FISHEYE", false)] {
        let cameras = json!({ "frames": [camera(1, "OPENCV"), camera(2, other)] });
        folder.write("c.json", &cameras.to_string());
        if is_common {
            folder.succeed(&job);
            assert_eq!(frames(&folder, "out/transforms.json"), [1, 2]);
        } else {
            let said = folder.fail(2, &[&job[..], &["--overwrite"]].concat());
            assert!(said.contains("one camera model for all frames"), "{said}");
            // Each model by itself.
            folder.succeed(&[&job[..], &["--range", "2"]].concat());
        }
    }
}
