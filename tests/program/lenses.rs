//! Cameras by their intrinsics: the files that tell them.

use crate::{
    common::{Folder, stderr},
    datasets::{check_transforms, numbers},
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
        let args = [
            "s.toml",
            "--frames",
            "path.csv",
            "--aovs",
            "P",
            "--metadata",
            "transforms",
        ];
        for window in [&[][..], &["--crop", "14,9,50,44"], &["--overscan", "8"]] {
            folder.succeed(&[&args[..], &pictures, window].concat());
            check_transforms(&folder);
        }
        let transforms: Value = serde_json::from_slice(&folder.read("out/transforms.json")).expect("JSON");
        assert_eq!(transforms["camera_model"], model);
        let row = &transforms["frames"][0]["transform_matrix"][0];
        assert_eq!(numbers(row).len(), 4);
    }
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
