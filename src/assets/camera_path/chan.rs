//! Nuke's `.chan`: a line of numbers for every frame.
//!
//! `frame tx ty tz rx ry rz` and, for a camera, `vfov`, the angle over the picture's height in degrees. Numbers are separated by
//! blanks; `#` begins a comment. The camera looks along its -z with +y up; angles are in degrees, in the order `ZXY`
//! of a new camera of Nuke, unless an option says another, and lengths are taken for metres. Frames that are left out
//! lie on curves between the others.
//!
//! Source: The Foundry, "Nuke User Guide", channel files; Blender's manual, "Nuke Animation (chan)", for the columns.

use std::fmt::Write as _;

use glam::DVec3;

use super::{
    CameraPathFormat, PathProblem, PathProblems,
    held::{Holds, POSES, Target, Written},
    source::{self, Source, Words},
    still::Still,
};
use crate::camera::{
    LensOverrides, RotationOrder,
    lens::FieldOfView,
    path::{CameraPath, Interp, Orientation, PathKey, Rotation},
};

const NAMES: [&str; 6] = ["tx", "ty", "tz", "rx", "ry", "rz"];

pub(super) const FORMAT: CameraPathFormat = CameraPathFormat {
    name: "chan",
    extensions: &["chan"],
    names: &[],
    read,
    holds: Holds { view: true, ..POSES },
    write,
};

fn read(source: &Source<'_>) -> Result<CameraPath, PathProblems> {
    let order = source.options.rotation_order.unwrap_or(RotationOrder::Zxy);
    let (mut keys, mut problems) = (Vec::<PathKey>::new(), PathProblems::default());
    let mut columns = None;
    for words in source::lines(source.text()?) {
        let count = *columns.get_or_insert(words.words.len());
        match key(&words, count, order) {
            Ok(key) if keys.last().is_some_and(|last| last.frame >= key.frame) => {
                let message = format!(
                    "frame {} comes after {}: frames must rise",
                    key.frame,
                    keys[keys.len() - 1].frame
                );
                problems.push(PathProblem::of_cell(words.line, "frame", message));
            }
            Ok(key) => keys.push(key),
            Err(problem) => problems.push(problem),
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    CameraPath::new(&keys).map_err(|e| PathProblem::of_file(e.to_string()).into())
}

fn key(words: &Words<'_>, count: usize, order: RotationOrder) -> Result<PathKey, PathProblem> {
    let found = words.words.len();
    if !(7..=8).contains(&found) {
        return Err(words.problem(format!(
            "the line has {found} numbers, expected frame, {} and vfov",
            NAMES.join(", ")
        )));
    }
    if found != count {
        return Err(words.problem(format!("the line has {found} numbers, the first line {count}")));
    }
    let frame = words.frame(0)?;
    let [x, y, z, rx, ry, rz] = words.numbers(1, NAMES)?;
    let view = (count == 8).then(|| words.number(7, "vfov")).transpose()?;
    if let Some(degrees) = view.filter(|degrees| !(*degrees > 0.0 && *degrees < 180.0)) {
        let message = format!("{degrees} is not above 0 and below 180 degrees");
        return Err(PathProblem::of_cell(words.line, "vfov", message));
    }
    let degrees = DVec3::new(rx, ry, rz);
    Ok(PathKey {
        frame: frame as f64,
        eye: DVec3::new(x, y, z),
        orientation: Orientation::Rotation(Rotation::Euler { degrees, order }),
        lens: LensOverrides {
            view: view.map(FieldOfView::Vertical),
            ..LensOverrides::default()
        },
        pinhole: None,
        shutter: None,
        readout: None,
        stereo: [None; 2],
        interp: Interp::Smooth,
        name: None,
    })
}

/// Angles go on from those of the frame before.
fn write(target: &Target<'_>, cameras: &[Still]) -> Written {
    let order = target.rotation_order.unwrap_or(RotationOrder::Zxy);
    let has_view = cameras
        .iter()
        .any(|camera| camera.fov.is_some() || camera.pixels.is_some());
    let (mut text, mut before) = (String::new(), DVec3::ZERO);
    for camera in cameras {
        let angles = order.angles(&camera.axes);
        let angles = angles + ((before - angles) / 360.0).round() * 360.0;
        before = angles;
        write!(text, "{}", camera.frame).expect("a text grows");
        let view = has_view.then(|| camera.view("chan")).transpose()?;
        for number in camera.eye.to_array().into_iter().chain(angles.to_array()).chain(view) {
            write!(text, "\t{}", number + 0.0).expect("a text grows");
        }
        text.push('\n');
    }
    target.file(text)
}
