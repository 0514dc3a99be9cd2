//! Cameras by their intrinsics: the files that tell them.

use crate::{
    common::{Folder, stderr},
    datasets::{check_transforms, column, numbers},
};
use glam::{DVec2, DVec3};
use serde_json::Value;

const SCENE: &str = "[render]\nwidth = 64\nheight = 48\nsamples = 1\n[material.m]\nmatte = { albedo = 0.5 }\n\
    [[object]]\nname = \"ball\"\nmaterial = \"m\"\nshape.sphere = { center = [0, 0, 0], radius = 1.5 }\n";

/// The pixel at which a frame of `transforms.json` sees a direction of its camera, of which x is to the right, y downwards and z along
/// the line of sight; by the formulas of OpenCV.
pub fn pixel_of(transforms: &Value, frame: &Value, d: DVec3) -> DVec2 {
    let number = |name: &str| frame[name].as_f64().expect("a number");
    let p = d.truncate() / d.z;
    let r2 = p.length_squared();
    let place = match transforms["camera_model"].as_str().expect("a name") {
        "PINHOLE" => p,
        "OPENCV" => {
            let [k1, k2, k3, p1, p2] = ["k1", "k2", "k3", "p1", "p2"].map(number);
            let radial = 1.0 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
            p * radial
                + DVec2::new(
                    2.0 * p1 * p.x * p.y + p2 * (r2 + 2.0 * p.x * p.x),
                    p1 * (r2 + 2.0 * p.y * p.y) + 2.0 * p2 * p.x * p.y,
                )
        }
        "OPENCV_FISHEYE" => {
            let [k1, k2, k3, k4] = ["k1", "k2", "k3", "k4"].map(number);
            let t = libm::atan2(d.truncate().length(), d.z);
            let t2 = t * t;
            let distance = t * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))));
            d.truncate().normalize() * distance
        }
        other => unreachable!("{other} is no model"),
    };
    DVec2::new(number("cx"), number("cy")) + place * DVec2::new(number("fl_x"), number("fl_y"))
}

#[test]
fn points_are_seen_where_transforms_of_distorted_cameras_say() {
    for (distortion, model) in [
        ("", "PINHOLE"),
        ("distortion.opencv = [-0.21, 0.08, 0.004, -0.002, -0.01]\n", "OPENCV"),
        (
            "distortion.kannala_brandt = [-0.02, 0.01, -0.003, 0.0005]\n",
            "OPENCV_FISHEYE",
        ),
    ] {
        let folder = Folder::new();
        let camera =
            "[camera.pinhole]\neye = [0, 1, 4]\ntarget = [0, 0, 0]\nsize = [640, 480]\nfx = 500\nfy = 520\ncx = 330\n";
        folder.write("s.toml", &format!("{SCENE}{camera}{distortion}"));
        folder.write(
            "path.csv",
            "frame, eye_x, eye_y, eye_z, target_x, target_y, target_z\n3, 0, 1, 4, 0, 0, 0\n4, 3, 0, 2, 0, 0, 0\n",
        );
        let pictures = ["-o", "out/f.####.exr", "-o", "out/f.####.png", "--progress", "none"];
        let args = ["s.toml", "--frames", "path.csv", "--aovs", "P", "--metadata", "colmap"];
        for window in [&[][..], &["--crop", "14,9,50,44"], &["--overscan", "8"]] {
            folder.succeed(&[&args[..], &pictures, window].concat());
            check_transforms(&folder);
            check_colmap(&folder);
        }
        let transforms: Value = serde_json::from_slice(&folder.read("out/transforms.json")).expect("JSON");
        assert_eq!(transforms["camera_model"], model);
        let row = &transforms["frames"][0]["transform_matrix"][0];
        assert_eq!(numbers(row).len(), 4);
    }
}

#[test]
fn points_are_seen_where_the_intrinsics_of_each_row_say() {
    let perspective = "[camera.perspective]\neye = [0, 1, 4]\ntarget = [0, 0, 0]\n";
    let pinhole = "[camera.pinhole]\neye = [0, 1, 4]\ntarget = [0, 0, 0]\nfx = 10\nsize = [9, 9]\ncy = 9\n";
    for (camera, columns, model) in [
        (perspective, "fx,cx,skew", "PINHOLE"),
        (perspective, "fx,fy,cx,cy,k1,p2,k3", "OPENCV"),
        (pinhole, "fx,cx,cy,fisheye_k1,fisheye_k3", "OPENCV_FISHEYE"),
        (pinhole, "cx,cy,fx,k1,k2,p1", "OPENCV"),
    ] {
        let folder = Folder::new();
        folder.write("s.toml", &format!("{SCENE}{camera}"));
        let value = |column: &str, last: bool| match column {
            "fx" => [500.0, 440.0][usize::from(last)],
            "fy" => [520.0, 480.0][usize::from(last)],
            "cx" => [330.0, 322.5][usize::from(last)],
            "cy" => [236.0, 240.5][usize::from(last)],
            "k1" => [-0.21, -0.11][usize::from(last)],
            "skew" => 0.0,
            _ => [0.004, -0.002][usize::from(last)],
        };
        let cells = |last: bool| {
            let cells = columns.split(',').map(|column| value(column, last).to_string());
            cells.collect::<Vec<_>>().join(",")
        };
        folder.write(
            "path.csv",
            &format!(
                "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,interp,width,height,{columns}\n\
                 3,0,1,4,0,0,0,linear,640,480,{}\n5,3,0,2,0,0,0,,640,480,{}\n",
                cells(false),
                cells(true)
            ),
        );
        let pictures = ["-o", "out/f.####.exr", "-o", "out/f.####.png", "--progress", "none"];
        let args = [
            "s.toml",
            "--frames",
            "path.csv",
            "--aovs",
            "P",
            "--metadata",
            "transforms",
        ];
        for window in [&[][..], &["--crop", "14,9,50,44"]] {
            folder.succeed(&[&args[..], &pictures, window].concat());
            check_transforms(&folder);
        }
        let transforms: Value = serde_json::from_slice(&folder.read("out/transforms.json")).expect("JSON");
        assert_eq!(transforms["camera_model"], model);
        // The scene's picture has a tenth of the size, and the crop begins at (14, 9).
        for (i, frame) in transforms["frames"].as_array().expect("frames").iter().enumerate() {
            let at = |column: &str| {
                let [first, last] = [false, true].map(|last| value(column, last));
                first + (last - first) * i as f64 / 2.0
            };
            let near = |key: &str, expected: f64| {
                let found = number_of(&frame[key]);
                assert!((found - expected).abs() < 1e-9, "{columns}: {key} {found} {expected}");
            };
            let fy = if columns.contains("fy") { at("fy") } else { at("fx") };
            near("fl_x", at("fx") / 10.0);
            near("fl_y", fy / 10.0);
            near("cx", at("cx") / 10.0 - 14.0);
            for column in columns
                .split(',')
                .filter(|column| column.len() == 2 && &column[1..] < "9")
            {
                near(column, at(column));
            }
        }
    }
}

#[test]
fn a_lens_column_that_no_camera_has_a_use_for_is_refused() {
    let folder = Folder::new();
    folder.write(
        "s.toml",
        &format!("{SCENE}[camera.perspective]\neye = [0, 1, 4]\ntarget = [0, 0, 0]\n"),
    );
    let refused = |columns: &str, cells: &str, message: &str| {
        let header = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z";
        folder.write("p.csv", &format!("{header},{columns}\n1,0,1,4,0,0,0,{cells}\n"));
        let output = folder.run(&["s.toml", "--frames", "p.csv", "-o", "f.####.exr"]);
        let text = stderr(&output);
        assert!(!output.status.success() && text.contains(message), "{columns}: {text}");
    };
    refused("cx,k1", "3,0.1", "the scene's perspective camera has no use for cx, k1");
    refused("fx,fov", "30,40", "pinhole camera has no use for fov");
    refused("fx,width", "30,40", "missing column: height");
    refused("fx,width,height", "30,4.5,8", "4.5 is not a whole number above 0");
    refused("fx", "0", "0 is not above 0");
    refused("fx,k1,fisheye_k2", "30,0.1,0.1", "coefficients of two models");
}

/// Compares the reconstruction of COLMAP with `transforms.json`: poses and parameters.
fn check_colmap(folder: &Folder) {
    let transforms: Value = serde_json::from_slice(&folder.read("out/transforms.json")).expect("JSON");
    let lines = |name: &str| -> Vec<Vec<String>> {
        let text = String::from_utf8(folder.read(&format!("out/sparse/0/{name}"))).expect("UTF-8");
        let lines = text.lines().filter(|line| !line.starts_with('#'));
        lines
            .map(|line| line.split_whitespace().map(str::to_owned).collect())
            .collect()
    };
    let parsed = |words: &[String]| -> Vec<f64> { words.iter().map(|word| word.parse().expect("a number")).collect() };
    let [camera] = &lines("cameras.txt")[..] else {
        panic!("cameras with the same numbers are one")
    };
    let images = lines("images.txt");
    let frames = transforms["frames"].as_array().expect("frames");
    assert_eq!(images.len(), 2 * frames.len());
    assert!(lines("points3D.txt").is_empty());
    for (image, frame) in images.chunks(2).zip(frames) {
        let number = |name: &str| frame[name].as_f64().unwrap_or(0.0);
        let names = match &camera[1][..] {
            "PINHOLE" => &["fl_x", "fl_y", "cx", "cy"][..],
            "OPENCV_FISHEYE" => &["fl_x", "fl_y", "cx", "cy", "k1", "k2", "k3", "k4"],
            "FULL_OPENCV" => &["fl_x", "fl_y", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "", "", ""],
            other => panic!("{other}"),
        };
        let expected: Vec<f64> = names.iter().map(|name| number(name)).collect();
        let found = parsed(&camera[4..]);
        assert_eq!(found.len(), expected.len());
        assert!(
            found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9),
            "{found:?}"
        );
        assert_eq!(
            parsed(&camera[2..4]),
            [number_of(&transforms["w"]), number_of(&transforms["h"])]
        );

        let [head, points] = image else {
            panic!("two lines an image")
        };
        assert!(points.is_empty());
        assert_eq!(
            (&head[8][..], &head[9][..]),
            ("1", frame["file_path"].as_str().expect("a name"))
        );
        let [w, x, y, z, tx, ty, tz] = parsed(&head[1..8])[..] else {
            panic!("a pose has seven numbers")
        };
        let rotation = glam::DQuat::from_xyzw(x, y, z, w);
        let column = |c: usize| column(frame, c);
        for point in [DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0), DVec3::new(-4.0, 0.5, 7.0)] {
            let from_eye = point - column(3);
            let [right, up, back] = [0, 1, 2].map(|c| from_eye.dot(column(c)));
            let seen = rotation * point + DVec3::new(tx, ty, tz);
            assert!(seen.abs_diff_eq(DVec3::new(right, -up, -back), 1e-12), "{seen}");
        }
    }
}

fn number_of(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn what_a_distortion_cannot_see_is_a_warning_and_empty_and_what_no_file_can_tell_is_refused() {
    let folder = Folder::new();
    let camera =
        "[camera.pinhole]\neye = [0, 1, 4]\ntarget = [0, 0, 0]\nfx = 20\ndistortion.opencv = [-0.5, 0, 0, 0]\n";
    folder.write("s.toml", &format!("{SCENE}{camera}"));
    let said = stderr(&folder.run(&["s.toml", "-o", "f.png", "--progress", "none"]));
    assert!(said.contains("the distortion of the camera has no ray for"), "{said}");
    let picture = image::load_from_memory(&folder.read("f.png"))
        .expect("a PNG")
        .into_rgba8();
    assert_eq!(picture.get_pixel(0, 0).0, [0; 4]);
    assert_eq!(picture.get_pixel(32, 24).0[3], 255);
    let error = folder.fail(
        2,
        &[
            "s.toml",
            "-o",
            "f.png",
            "--metadata",
            "transforms",
            "--set",
            "camera.pinhole.distortion.opencv=[0,0,0,0,0,0.1,0,0]",
        ],
    );
    assert!(error.contains("up to five numbers of `opencv`"), "{error}");
}
