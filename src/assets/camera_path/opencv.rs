//! Calibrations of OpenCV: YAML files of its `FileStorage`, as its samples and ROS write them.
//!
//! | key | content |
//! |---|---|
//! | `camera_matrix` | 3x3: focal lengths, skew and centre, in pixels whose centres are at whole numbers |
//! | `distortion_coefficients` | 4, 5, 8, 12 or 14 numbers (the last two, a tilt, must be 0), or none |
//! | `image_width`, `image_height` | pixels |
//! | `fisheye_model`, or `distortion_model: equidistant` | 1, or the word: the coefficients are the 4 of `cv::fisheye` |
//! | `rvec`, `tvec` | 3 numbers each: the map from the world, in m, to a camera that looks along +z with +y down, the rotation as a vector (axis times radians) |
//! | `extrinsic_parameters` | instead: rows of `rvec` and `tvec`, one for each frame, counted from 1 |
//!
//! Keys may be in any case, other keys are ignored. A file without a pose is a lens: the pose is that of the scene's camera.
//!
//! Source: OpenCV's documentation, "Camera Calibration and 3D Reconstruction", "XML/YAML file storages" and
//! the tutorial "Camera calibration".

use std::fmt::Write as _;

use glam::{DQuat, DVec3};

use super::{
    CameraPathFormat, PathProblem, PathProblems,
    held::{Holds, Numbers, Target, Written},
    keys::{self, Frames, Intrinsics, Posed},
    source::Source,
    still::Still,
};
use crate::camera::{ViewDistortion, path::CameraPath, pinhole::PinholeLens};

mod yaml;

use yaml::Document;

/// The distance from a corner of the picture to the centre of its first pixel.
const HALF_PIXEL: f64 = 0.5;

pub(super) const FORMAT: CameraPathFormat = CameraPathFormat {
    name: "opencv",
    extensions: &["yaml", "yml"],
    names: &[],
    read,
    holds: Holds {
        numbers: Numbers::Counted,
        names: false,
        view: true,
        center: true,
        pixels: true,
        skew: true,
        distortion: |_| true,
    },
    write,
};

fn read(source: &Source<'_>) -> Result<CameraPath, PathProblems> {
    let document = Document::new(source.text()?);
    let lens = lens(&document)?;
    let poses = poses(&document)?;
    let posed = match (poses.is_empty(), source.options.pose) {
        (false, _) => poses,
        (true, Some(pose)) => {
            let place = pose.world_from_camera();
            vec![Posed::new(place.translation, DQuat::from_mat3(&place.matrix3))]
        }
        (true, None) => {
            return Err(PathProblem::of_file(
                "the file has no pose: no `rvec` and `tvec`, and no `extrinsic_parameters`",
            )
            .into());
        }
    };
    let numbered = posed.into_iter().enumerate().map(|(i, posed)| {
        let pinhole = Some(lens);
        ((i + 1) as f64, Posed { pinhole, ..posed })
    });
    keys::path(numbered, Frames::Pictures)
}

fn lens(document: &Document<'_>) -> Result<PinholeLens, PathProblem> {
    let matrix = document.find("camera_matrix");
    let matrix = matrix.ok_or_else(|| PathProblem::of_file("the file has no `camera_matrix`"))?;
    let (_, numbers) = matrix.matrix()?;
    let [fx, skew, cx, 0.0, fy, cy, 0.0, 0.0, 1.0] = numbers[..] else {
        return Err(matrix.problem("expected 3x3 numbers `fx, skew, cx, 0, fy, cy, 0, 0, 1`"));
    };
    let size = |name: &str| document.find(name).map(|entry| entry.number()).transpose();
    let (width, height) = (size("image_width")?, size("image_height")?);
    let intrinsics = Intrinsics {
        focal: [fx, fy],
        center: [cx, cy].map(|c| Some(c + HALF_PIXEL)),
        skew,
        size: width.zip(height).map(|(width, height)| [width, height]),
        distortion: distortion(document)?,
    };
    intrinsics.lens().map_err(|message| matrix.problem(message))
}

fn distortion(document: &Document<'_>) -> Result<ViewDistortion, PathProblem> {
    let is_fisheye = match (document.find("fisheye_model"), document.find("distortion_model")) {
        (Some(entry), _) => entry.number()? != 0.0,
        (None, Some(entry)) => match entry.word() {
            "equidistant" | "fisheye" => true,
            "plumb_bob" | "rational_polynomial" => false,
            other => return Err(entry.problem(format!("the distortion model `{other}` is not rendered"))),
        },
        (None, None) => false,
    };
    let Some(entry) = document.find("distortion_coefficients") else {
        return Ok(ViewDistortion::None);
    };
    let (_, numbers) = entry.matrix()?;
    match (is_fisheye, &numbers[..]) {
        (true, [k1, k2, k3, k4]) => Ok(ViewDistortion::OpenCvFisheye([*k1, *k2, *k3, *k4])),
        (true, _) => Err(entry.problem(format!("a fisheye has 4 coefficients, found {}", numbers.len()))),
        (false, []) => Ok(ViewDistortion::None),
        (false, [.., tilt_x, tilt_y]) if numbers.len() == 14 && [*tilt_x, *tilt_y] != [0.0; 2] => {
            Err(entry.problem("the tilt of the sensor, the last two coefficients, is not rendered"))
        }
        (false, _) if [4, 5, 8, 12, 14].contains(&numbers.len()) => {
            Ok(ViewDistortion::OpenCv(std::array::from_fn(|i| {
                numbers.get(i).copied().unwrap_or(0.0)
            })))
        }
        (false, _) => Err(entry.problem(format!(
            "expected 4, 5, 8, 12 or 14 coefficients, found {}",
            numbers.len()
        ))),
    }
}

/// The poses of all frames; empty if the file has none.
fn poses(document: &Document<'_>) -> Result<Vec<Posed>, PathProblem> {
    if let Some(entry) = document.find("extrinsic_parameters") {
        let ([_, columns], numbers) = entry.matrix()?;
        if columns != 6 || numbers.is_empty() {
            return Err(entry.problem("expected rows of 6 numbers, rvec and tvec"));
        }
        let rows = numbers.as_chunks::<6>().0.iter();
        return Ok(rows
            .map(|[rx, ry, rz, tx, ty, tz]| posed([*rx, *ry, *rz], [*tx, *ty, *tz]))
            .collect());
    }
    let vector = |name: &str| {
        let Some(entry) = document.find(name) else {
            return Ok(None);
        };
        match entry.matrix()?.1[..] {
            [x, y, z] => Ok(Some([x, y, z])),
            _ => Err(entry.problem("expected 3 numbers")),
        }
    };
    match (vector("rvec")?, vector("tvec")?) {
        (Some(rotation), Some(translation)) => Ok(vec![posed(rotation, translation)]),
        (None, None) => Ok(Vec::new()),
        _ => Err(PathProblem::of_file("either `rvec` or `tvec` is missing")),
    }
}

fn posed(rotation: [f64; 3], translation: [f64; 3]) -> Posed {
    Posed::of_extrinsics(rotation_of(DVec3::from_array(rotation)), DVec3::from_array(translation))
}

/// The rotation about the axis `vector` by its length in radians.
fn rotation_of(vector: DVec3) -> DQuat {
    let angle = vector.length();
    if angle == 0.0 {
        return DQuat::IDENTITY;
    }
    let (sin, cos) = libm::sincos(0.5 * angle);
    DQuat::from_vec4((vector * (sin / angle)).extend(cos)).normalize()
}

/// The vector of a rotation whose `w` is at least 0.
fn vector_of(rotation: DQuat) -> DVec3 {
    let (axis, cos) = (rotation.xyz(), rotation.w);
    let sin = axis.length();
    match sin > 0.0 {
        true => axis * (2.0 * libm::atan2(sin, cos) / sin),
        false => DVec3::ZERO,
    }
}

fn write(target: &Target<'_>, cameras: &[Still]) -> Written {
    let lens = cameras[0].lens("opencv")?;
    for camera in &cameras[1..] {
        let other = camera.lens("opencv")?;
        if !other.is_near(lens) {
            return Err(format!(
                "opencv files have one lens, and that of frame {} differs from that of frame {}",
                camera.frame, cameras[0].frame
            ));
        }
    }
    let mut text = "%YAML:1.0\n---\n".to_owned();
    if let Some([width, height]) = lens.size {
        write!(text, "image_width: {width}\nimage_height: {height}\n").expect("a text grows");
    }
    let ([fx, fy], [cx, cy]) = (lens.focal, lens.center.map(|c| c.unwrap_or_default() - HALF_PIXEL));
    let matrix = [fx, lens.skew, cx, 0.0, fy, cy, 0.0, 0.0, 1.0];
    put_matrix(&mut text, "camera_matrix", [3, 3], &matrix);
    let (coefficients, is_fisheye) = match lens.distortion {
        ViewDistortion::None => (vec![0.0; 5], false),
        ViewDistortion::OpenCvFisheye(k) => (k.to_vec(), true),
        ViewDistortion::OpenCv(all) => {
            let used = all.iter().rposition(|k| *k != 0.0).map_or(0, |last| last + 1);
            let count = [5, 8, 12].into_iter().find(|count| *count >= used).unwrap_or(12);
            (all[..count].to_vec(), false)
        }
    };
    put_matrix(
        &mut text,
        "distortion_coefficients",
        [coefficients.len(), 1],
        &coefficients,
    );
    writeln!(text, "fisheye_model: {}", u8::from(is_fisheye)).expect("a text grows");
    let poses = cameras.iter().map(|camera| {
        let (rotation, translation) = camera.extrinsics();
        [vector_of(rotation).to_array(), translation.to_array()]
    });
    let poses: Vec<[[f64; 3]; 2]> = poses.collect();
    if let [[rotation, translation]] = &poses[..] {
        put_matrix(&mut text, "rvec", [3, 1], rotation);
        put_matrix(&mut text, "tvec", [3, 1], translation);
    } else {
        put_matrix(
            &mut text,
            "extrinsic_parameters",
            [poses.len(), 6],
            poses.as_flattened().as_flattened(),
        );
    }
    target.file(text)
}

fn put_matrix(text: &mut String, name: &str, [rows, columns]: [usize; 2], numbers: &[f64]) {
    let numbers: Vec<String> = numbers.iter().map(|v| format!("{v:?}")).collect();
    let data = numbers.join(", ");
    let head = format!("{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n");
    writeln!(text, "{head}   data: [ {data} ]").expect("a text grows");
}
