//! The cameras of a sequence as a reconstruction of COLMAP, in its form of texts: `cameras.txt`, `images.txt` and a `points3D.txt` without
//! points.
//!
//! A camera of COLMAP looks along its +z with +y down, and poses go from the world to the camera. Pixel centres are at .5. Source:
//! Schönberger and Frahm, "Structure-from-Motion Revisited", CVPR 2016; colmap.github.io, "Output Format".

use std::fmt::Write as _;

use glam::{DMat3, DQuat, DVec3};

use super::transforms::{Coefficients, Frame, Transforms};

/// The names and the texts of the files.
pub(super) fn files(transforms: &Transforms) -> [(&'static str, String); 3] {
    let mut cameras: Vec<String> = Vec::new();
    let mut images =
        String::from("# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME, and a line without points\n");
    for (i, frame) in transforms.frames.iter().enumerate() {
        let camera = camera(transforms, frame);
        let number = cameras.iter().position(|other| *other == camera).unwrap_or_else(|| {
            cameras.push(camera);
            cameras.len() - 1
        });
        let (rotation, translation) = world_to_camera(&frame.transform_matrix);
        let DQuat { x, y, z, w } = rotation;
        let DVec3 { x: tx, y: ty, z: tz } = translation;
        let (id, number, name) = (i + 1, number + 1, &frame.file_path);
        writeln!(images, "{id} {w} {x} {y} {z} {tx} {ty} {tz} {number} {name}\n").expect("a text grows");
    }
    let mut lines = String::from("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n");
    for (i, camera) in cameras.iter().enumerate() {
        writeln!(lines, "{} {camera}", i + 1).expect("a text grows");
    }
    let points = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[]\n".to_owned();
    [("cameras.txt", lines), ("images.txt", images), ("points3D.txt", points)]
}

/// The model, the size and the parameters of a frame's camera.
fn camera(transforms: &Transforms, frame: &Frame) -> String {
    // Intrinsics of turned cameras differ in their last digits only, and the cameras are one.
    let pixels = |v: f64| (v * 1e9).round() / 1e9;
    let [fl_x, fl_y, cx, cy] = [frame.fl_x, frame.fl_y, frame.cx, frame.cy].map(pixels);
    let Coefficients { k1, k2, k3, k4, p1, p2 } = frame.distortion;
    let [k1, k2, k3, k4, p1, p2] = [k1, k2, k3, k4, p1, p2].map(Option::unwrap_or_default);
    let (model, more) = match (&*transforms.camera_model, k3) {
        ("PINHOLE", _) => ("PINHOLE", vec![]),
        ("OPENCV_FISHEYE", _) => ("OPENCV_FISHEYE", vec![k1, k2, k3, k4]),
        (_, 0.0) => ("OPENCV", vec![k1, k2, p1, p2]),
        _ => ("FULL_OPENCV", vec![k1, k2, p1, p2, k3, 0.0, 0.0, 0.0]),
    };
    let mut text = format!("{model} {} {} {fl_x} {fl_y} {cx} {cy}", transforms.w, transforms.h);
    for number in more {
        write!(text, " {number}").expect("a text grows");
    }
    text
}

/// The pose of a camera that looks along its +z with +y down.
fn world_to_camera(matrix: &[[f64; 4]; 4]) -> (DQuat, DVec3) {
    let column = |i: usize| DVec3::new(matrix[0][i], matrix[1][i], matrix[2][i]);
    // The columns of the inverse of a rotation are the rows of its matrix.
    let to_camera = DMat3::from_cols(column(0), -column(1), -column(2)).transpose();
    let rotation = DQuat::from_mat3(&to_camera);
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    (rotation, -(to_camera * column(3)))
}
