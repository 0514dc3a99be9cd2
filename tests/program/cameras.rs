//! Cameras from other programs' files. The cameras that a job writes are a camera path of the same pictures.

use crate::{
    common::Folder,
    datasets::{check_transforms, column, numbers},
};
use serde_json::Value;

/// A job of the cameras in a file.
const OF_JSON: [&str; 7] = [
    "plain.toml",
    "--frames",
    "cameras.json",
    "--samples",
    "1",
    "-o",
    "f.####.exr",
];

const SCENE: &str = "[camera]\npinhole = { eye = [0, 1, 4], target = [0, 0, 0], size = [128, 96], fx = 140, fy = 144, cx = 60, cy = 50, \
    distortion.opencv = [-0.2, 0.05, 0.001, -0.002] }\n\
    [material.m]\nmatte = { albedo = 0.5 }\n\
    [[object]]\nmaterial = \"m\"\nshape.sphere = { center = [0.3, 0, 0], radius = 1 }\n";

/// The same scene with another camera.
fn plain() -> String {
    let start = SCENE.find("pinhole").expect("the camera");
    let end = start + SCENE[start..].find('\n').expect("an end of the line");
    let camera = "perspective = { eye = [9, 9, 9], target = [0, 0, 0] }";
    [&SCENE[..start], camera, &SCENE[end..]].concat()
}

fn transforms(folder: &Folder, name: &str) -> Value {
    serde_json::from_slice(&folder.read(name)).expect("JSON")
}

/// Compares the numbers of two files of cameras.
fn assert_same_cameras(a: &Value, b: &Value) {
    let frames = |value: &Value| value["frames"].as_array().expect("frames").clone();
    assert_eq!(
        (&a["w"], &a["h"], &a["camera_model"]),
        (&b["w"], &b["h"], &b["camera_model"])
    );
    assert_eq!(frames(a).len(), frames(b).len());
    for (a, b) in frames(a).iter().zip(&frames(b)) {
        assert_eq!((&a["frame"], &a["file_path"]), (&b["frame"], &b["file_path"]));
        for key in ["fl_x", "fl_y", "cx", "cy", "k1", "k2", "k3", "p1", "p2"] {
            let [a, b] = [a, b].map(|frame| frame[key].as_f64().expect("a number"));
            assert!((a - b).abs() < 1e-9, "{key}: {a} and {b}");
        }
        for c in 0..4 {
            assert!((column(a, c) - column(b, c)).length() < 1e-9);
        }
        assert_eq!(numbers(&a["transform_matrix"][3]), [0.0, 0.0, 0.0, 1.0]);
    }
}

#[test]
fn the_cameras_that_a_job_writes_are_a_camera_path_of_the_same_pictures() {
    let folder = Folder::new();
    folder.write("s.toml", SCENE);
    folder.write("plain.toml", &plain());
    folder.write(
        "path.csv",
        "frame, eye_x, eye_y, eye_z, target_x, target_y, target_z\n3, 0, 1, 4, 0, 0, 0\n4, 3, 0, 2, 0, 0, 0\n",
    );
    let flags = [
        "--samples",
        "1",
        "--aovs",
        "P",
        "--metadata",
        "transforms,colmap",
        "--progress",
        "none",
    ];
    let pictures = ["-o", "out/f.####.exr", "-o", "out/f.####.png"];
    let size = ["--resolution", "64x48"];
    folder.succeed(&[&["s.toml", "--frames", "path.csv"], &flags[..], &pictures, &size].concat());
    let first = transforms(&folder, "out/transforms.json");
    let light = folder.read("out/f.0003.png");
    std::fs::rename(folder.path("out"), folder.path("first")).expect("renamed");
    for cameras in [
        "first/transforms.json",
        "first/sparse/0",
        "first/sparse/0/images.txt",
        "first/sparse/0/cameras.txt",
    ] {
        // The size is that of the file, and the pictures have their frames.
        folder.succeed(&[&["plain.toml", "--frames", cameras], &flags[..], &pictures].concat());
        assert_same_cameras(&first, &transforms(&folder, "out/transforms.json"));
        check_transforms(&folder);
        let again = image::load_from_memory(&folder.read("out/f.0003.png"))
            .expect("a PNG")
            .into_rgba8();
        let light = image::load_from_memory(&light).expect("a PNG").into_rgba8();
        let difference = light.iter().zip(again.iter()).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(difference <= Some(1), "{cameras}: {difference:?}");
        std::fs::remove_dir_all(folder.path("out")).expect("removed");
    }
    // Another size scales the view.
    let small = ["--resolution", "32x24"];
    folder.succeed(
        &[
            &["plain.toml", "--frames", "first/sparse/0"],
            &flags[..],
            &pictures,
            &small,
        ]
        .concat(),
    );
    check_transforms(&folder);
    let scaled = transforms(&folder, "out/transforms.json");
    assert_eq!(scaled["w"], 32);
    let focal = |value: &Value| value["frames"][0]["fl_x"].as_f64().expect("a number");
    assert!((2.0 * focal(&scaled) - focal(&first)).abs() < 1e-9);
}

#[test]
fn pictures_are_frames_of_their_own_and_a_change_of_one_renders_it_alone() {
    let folder = Folder::new();
    folder.write("plain.toml", &plain());
    let cameras = |x: &str| {
        let frame = |number: &str, x: &str| {
            format!(
                r#"{{"file_path": "f_{number}.png", "transform_matrix": [[1, 0, 0, {x}], [0, 1, 0, 0], [0, 0, 1, 4]]}}"#
            )
        };
        let frames = [frame("010", "0"), frame("900", x)].join(", ");
        let text = format!(r#"{{"w": 16, "h": 12, "fl_x": 20, "frames": [{frames}]}}"#);
        folder.write("cameras.json", &text)
    };
    let job = [&OF_JSON[..], &["--skip-existing"]].concat();
    cameras("0.5");
    folder.succeed(&job);
    assert_eq!(
        folder.names(),
        ["cameras.json", "f.0010.exr", "f.0900.exr", "plain.toml"]
    );
    cameras("0.25");
    let stale = folder.succeed(&[&OF_JSON[..], &["--list-stale"]].concat());
    assert!(stale.lines().count() == 1 && stale.contains("f.0900.exr"), "{stale}");
    // A range may name frames between them.
    folder.succeed(&[&job[..], &["--range", "11"]].concat());
    assert!(folder.path("f.0011.exr").exists());
}

#[test]
fn pictures_of_several_sizes_need_one() {
    let folder = Folder::new();
    folder.write("plain.toml", &plain());
    let frame = |w: u32, x: u32| {
        format!(
            r#"{{"w": {w}, "h": 12, "fl_x": 20, "transform_matrix": [[1, 0, 0, {x}], [0, 1, 0, 0], [0, 0, 1, 4]]}}"#
        )
    };
    folder.write(
        "cameras.json",
        &format!(r#"{{"frames": [{}, {}]}}"#, frame(16, 0), frame(18, 1)),
    );
    let error = folder.fail(65, &OF_JSON);
    assert!(
        error.contains("some pictures have 16x12 pixels and others 18x12: choose one size (--resolution)"),
        "{error}"
    );
    folder.succeed(&[&OF_JSON[..], &["--resolution", "16x12"]].concat());
}

#[test]
fn a_calibration_alone_is_the_lens_of_the_scenes_camera() {
    let folder = Folder::new();
    folder.write("s.toml", SCENE);
    folder.write("plain.toml", &plain().replace("[9, 9, 9]", "[0, 1, 4]"));
    // Its pixel centres are at whole numbers.
    folder.write(
        "lens.yml",
        "%YAML:1.0\n---\nimage_width: 128\nimage_height: 96\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   \
         data: [ 140., 0., 59.5, 0., 144., 49.5, 0., 0., 1. ]\ndistortion_coefficients: [ -0.2, 0.05, 0.001, -0.002 ]\n",
    );
    let flags = [
        "--samples",
        "1",
        "--aovs",
        "P",
        "--exr-type",
        "float",
        "--progress",
        "none",
        "-o",
    ];
    folder.succeed(&[&["s.toml", "--resolution", "128x96"], &flags[..], &["a.exr"]].concat());
    folder.succeed(&[&["plain.toml", "--frames", "lens.yml"], &flags[..], &["b.exr"]].concat());
    let points = |name: &str| -> Vec<f32> {
        let image = folder.open_exr(name);
        let list = &image.layer_data[0].channel_data.list;
        let of_point = list.iter().filter(|channel| channel.name.to_string().starts_with("P."));
        of_point
            .flat_map(|channel| channel.sample_data.values_as_f32().collect::<Vec<_>>())
            .collect()
    };
    let (a, b) = (points("a.exr"), points("b.exr"));
    assert_eq!(a.len(), b.len());
    let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-5 && a.iter().any(|v| *v != 0.0), "{worst}");
}

#[test]
fn a_motion_that_leaves_frames_out_is_the_same_in_every_format() {
    let folder = Folder::new();
    folder.write("s.toml", &plain());
    folder.write(
        "sparse.chan",
        "1 0 1 6 0 0 0 40\n11 1 1 5 5 20 0 30\n16 3 1 5 0 10 0 40\n",
    );
    let render = |path: &str, out: &str| {
        let job = [
            "s.toml",
            "--frames",
            path,
            "--resolution",
            "16x12",
            "--samples",
            "1",
            "--range",
            "1,6,13",
            "-o",
            out,
        ];
        folder.succeed(&job);
    };
    render("sparse.chan", "own.##.png");
    for name in ["all.csv", "all.chan", "all.glb"] {
        folder.succeed(&[
            "convert-camera",
            "sparse.chan",
            name,
            "--fps",
            "24",
            "--resolution",
            "16x12",
        ]);
        if name == "all.glb" {
            continue;
        }
        render(name, "other.##.png");
        for frame in ["01", "06", "13"] {
            let picture = |name: &str| image::open(folder.path(&format!("{name}.{frame}.png"))).expect("a picture");
            let [own, other] = ["own", "other"].map(|name| picture(name).into_rgba8().into_raw());
            let differ = own.iter().zip(&other).filter(|(a, b)| a.abs_diff(**b) > 1).count();
            assert_eq!(differ, 0, "{name} {frame}");
        }
    }
    let rows = String::from_utf8(folder.read("all.csv")).expect("UTF-8");
    assert_eq!(
        rows.lines()
            .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()))
            .count(),
        16,
        "{rows}"
    );
}

#[test]
fn conversions_say_what_is_lost_and_leave_nothing_where_they_fail() {
    let folder = Folder::new();
    folder.write("path.csv", "frame, eye_x, eye_y, eye_z, target_x, target_y, target_z, fov\n1, 0, 0, 5, 0, 0, 0, 40\n3, 1, 0, 5, 1, 0, 0, 40\n");
    let said = crate::common::stderr(&folder.run(&["convert-camera", "path.csv", "camera.chan"]));
    assert_eq!(said, "");
    assert_eq!(
        String::from_utf8(folder.read("camera.chan")).expect("a text"),
        "1\t0\t0\t5\t0\t0\t0\t40\n2\t0.5\t0\t5\t0\t0\t0\t40\n3\t1\t0\t5\t0\t0\t0\t40\n"
    );
    folder.write(
        "rolling.csv",
        "frame, eye_x, eye_y, eye_z, target_x, target_y, target_z, fov, readout\n1, 0, 0, 5, 0, 0, 0, 40, 0.5\n",
    );
    let said = crate::common::stderr(&folder.run(&["convert-camera", "rolling.csv", "rolling.chan"]));
    assert!(
        said.contains("chan files do not hold depth of field and shutters"),
        "{said}"
    );
    let lens = r#"{"w": 8, "h": 6, "fl_x": 10, "k1": -0.1, "frames": [{"transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5]]}]}"#;
    folder.write("lens.json", lens);
    let said = crate::common::stderr(&folder.run(&["convert-camera", "lens.json", "lens.chan"]));
    assert_eq!(
        said.trim_end(),
        "warning: chan files do not hold the size of pictures, the distortion of the lens: left out: lens.chan"
    );
    // A trajectory with the lens of another file.
    folder.write("walk.tum", "0 0 0 5 1 0 0 0\n0.5 1 0 5 1 0 0 0\n");
    let error = folder.fail(65, &["convert-camera", "walk.tum", "walk.json", "--fps", "4"]);
    assert!(
        error.contains("frame 0 has no lens: name a file with one (--lens): walk.json"),
        "{error}"
    );
    folder.succeed(&[
        "convert-camera",
        "walk.tum",
        "model/0",
        "--fps",
        "4",
        "--lens",
        "lens.json",
    ]);
    assert_eq!(
        crate::common::names(&folder.path("model/0")),
        ["cameras.txt", "images.txt", "points3D.txt"]
    );
    let cameras = String::from_utf8(folder.read("model/0/cameras.txt")).expect("a text");
    assert!(cameras.ends_with("\n1 OPENCV 8 6 10 10 4 3 -0.1 0 0 0\n"), "{cameras}");
    let images = String::from_utf8(folder.read("model/0/images.txt")).expect("a text");
    assert!(
        images.contains(" 0000.png\n\n") && images.contains(" 0002.png\n\n"),
        "{images}"
    );
    let error = folder.fail(65, &["convert-camera", "path.csv", "path.json"]);
    assert!(
        error.contains("say the size of the pictures (--resolution): path.json"),
        "{error}"
    );
    let error = folder.fail(2, &["convert-camera", "path.csv", "./path.csv"]);
    assert!(error.contains("is a file that the job reads"), "{error}");
    folder.fail(66, &["convert-camera", "nowhere.csv", "camera.chan"]);
    folder.fail(65, &["convert-camera", "path.csv", "camera.xyz"]);
    assert_eq!(
        folder.names(),
        [
            "camera.chan",
            "lens.chan",
            "lens.json",
            "model",
            "path.csv",
            "rolling.chan",
            "rolling.csv",
            "walk.tum"
        ]
    );
}

#[test]
fn instances_of_parts_and_of_resumed_jobs_are_those_of_one_job() {
    let folder = Folder::new();
    let ball = |name: &str, x: f64| {
        format!(
            "[[object]]\nname = \"{name}\"\nmaterial = \"m\"\nshape.sphere = {{ center = [{x}, 0, 0], radius = 0.7 }}\n"
        )
    };
    let camera = "[render]\nwidth = 40\nheight = 30\nsamples = 1\n[camera]\nperspective = { eye = [0, 1, 4], target = [0, 0, 0] }\n\
        [material.m]\nmatte = { albedo = 0.5 }\n";
    folder.write(
        "s.toml",
        &[
            camera.to_owned(),
            ball("ball.001", -0.8),
            ball("ball.002", 0.8),
            ball("box", 0.0).replace("[0, 0, 0]", "[0, 3.5, 0]"),
        ]
        .concat(),
    );
    let job = |output: &str, more: &[&str]| {
        let pattern = format!("{output}/f.####.exr");
        let flags = [
            "s.toml",
            "--turntable",
            "3",
            "--aovs",
            "objectId",
            "--metadata",
            "coco",
            "--progress",
            "none",
            "-o",
            &pattern,
        ];
        folder.succeed(&[&flags[..], more].concat());
        folder.read(&format!("{output}/coco.json"))
    };
    let whole = job("whole", &[]);
    for part in ["3/3", "1/3", "2/3"] {
        job("parts", &["--part", part]);
    }
    assert!(folder.read("parts/coco.json") == whole);
    std::fs::remove_file(folder.path("whole/f.0002.exr")).expect("removed");
    assert!(job("whole", &["--skip-existing"]) == whole);
    let file: Value = serde_json::from_slice(&whole).expect("JSON");
    let list = |key: &str| file[key].as_array().expect("a list").clone();
    let names: Vec<Value> = list("categories")
        .iter()
        .map(|category| category["name"].clone())
        .collect();
    assert_eq!(names, ["ball", "box"]);
    assert_eq!(list("images").len(), 3);
    assert_eq!(list("images")[1]["file_name"], "f.0002.exr");
    let annotations = list("annotations");
    for (image, name) in [(1, "whole/f.0001.exr"), (3, "whole/f.0003.exr")] {
        let opened = folder.open_exr(name);
        let channels = &opened.layer_data[0].channel_data.list;
        let ids = channels
            .iter()
            .find(|channel| channel.name.to_string() == "objectId.Y")
            .expect("the pass");
        let ids: Vec<f32> = ids.sample_data.values_as_f32().collect();
        for object in 1..=2 {
            let of = |a: &&Value| a["image_id"] == image && a["object_id"] == object;
            let annotation = annotations.iter().find(of).expect("an instance");
            assert_eq!(annotation["id"], image * 1_000_000 + object);
            let pixels: Vec<usize> = (0..ids.len()).filter(|i| ids[*i] == object as f32).collect();
            assert_eq!(annotation["area"], pixels.len());
            let columns = pixels.iter().map(|i| i % 40);
            let rows = pixels.iter().map(|i| i / 40);
            let (x0, x1) = (columns.clone().min().expect("a pixel"), columns.max().expect("a pixel"));
            let (y0, y1) = (rows.clone().min().expect("a pixel"), rows.max().expect("a pixel"));
            assert_eq!(
                numbers(&annotation["bbox"]),
                [x0, y0, x1 + 1 - x0, y1 + 1 - y0].map(|n| n as f64)
            );
        }
    }
}

#[test]
fn cameras_that_go_through_csv_and_colmap_keep_their_lenses_and_frames() {
    let folder = Folder::new();
    folder.write("s.toml", SCENE);
    let poses = "-2,0,1,4,0,0,0,50\n-1,0,2,4,0,0,0,50\n0,0,1,5,0,0,0,50\n";
    folder.write(
        "a.csv",
        &format!("frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov\n{poses}"),
    );
    folder.succeed(&["convert-camera", "a.csv", "sparse", "--resolution", "32x24"]);
    folder.succeed(&["convert-camera", "sparse", "b.csv"]);
    let rows = String::from_utf8(folder.read("b.csv")).expect("UTF-8");
    let frames: Vec<&str> = rows.lines().skip(1).filter_map(|row| row.split(',').next()).collect();
    assert_eq!(frames, ["-2", "-1", "0"]);
    for (path, out) in [("sparse", "x.####.exr"), ("b.csv", "y.####.exr")] {
        folder.succeed(&["s.toml", "--frames", path, "--range", "0", "--samples", "1", "-o", out]);
    }
    folder.succeed(&["compare", "x.0000.exr", "y.0000.exr"]);
}
