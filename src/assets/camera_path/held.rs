//! The properties of cameras that a format stores, and those that a conversion loses.

use std::path::{Path, PathBuf};

use super::{keys::picture_frames, still::Still};
use crate::camera::{RotationOrder, ViewDistortion};

/// A file that is written.
pub(super) struct Target<'a> {
    pub path: &'a Path,
    /// Frames per second.
    pub fps: Option<f64>,
    pub rotation_order: Option<RotationOrder>,
}

/// Files with their contents, or why the format cannot hold the cameras.
pub(super) type Written = Result<Vec<(PathBuf, Vec<u8>)>, String>;

impl Target<'_> {
    /// The only file, of this content.
    pub fn file(&self, content: impl Into<Vec<u8>>) -> Written {
        Ok(vec![(self.path.to_owned(), content.into())])
    }
}

/// The way in which a format stores frame numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numbers {
    Written,
    /// As the last numbers of the names of pictures.
    InNames,
    /// Frames are counted from 1.
    Counted,
}

/// The properties of cameras that a format stores beside their poses.
#[derive(Clone, Copy, Debug)]
pub struct Holds {
    pub numbers: Numbers,
    pub names: bool,
    pub view: bool,
    pub center: bool,
    /// Focal lengths that differ across and down, and the size of the pictures.
    pub pixels: bool,
    pub skew: bool,
    pub distortion: fn(&ViewDistortion) -> bool,
}

/// Poses with numbers of frames, and nothing else.
pub const POSES: Holds = Holds {
    numbers: Numbers::Written,
    names: false,
    view: false,
    center: false,
    pixels: false,
    skew: false,
    distortion: |_| false,
};

/// The part that a conversion may know from elsewhere.
pub(super) const SIZE: &str = "the size of pictures";

/// The parts of the cameras that files of a format do not hold.
pub(super) fn lost(cameras: &[Still], holds: Holds) -> Vec<&'static str> {
    let any = |is: &dyn Fn(&Still) -> bool| cameras.iter().any(is);
    let differs = |a: f64, b: f64| (a - b).abs() > 1e-9 * b.abs().max(1.0);
    let of_lens = |is: &dyn Fn(&super::keys::Intrinsics) -> bool| any(&|camera| camera.pixels.as_ref().is_some_and(is));
    let has_view = any(&|camera| camera.fov.is_some() || camera.pixels.is_some());
    let frames: Vec<i64> = cameras.iter().map(|camera| camera.frame).collect();
    let is_counted = frames.iter().copied().eq(1..=frames.len() as i64);
    let keeps_frames = match holds.numbers {
        Numbers::Written => true,
        Numbers::InNames => {
            let names = cameras.iter().map(|camera| camera.name.as_deref());
            any(&|camera| camera.name.is_none()) || picture_frames(names) == frames
        }
        Numbers::Counted => is_counted,
    };
    let is_off_center = |lens: &super::keys::Intrinsics| {
        let center = lens.center.map(Option::unwrap_or_default);
        lens.size
            .is_some_and(|size| (0..2).any(|i| differs(center[i], 0.5 * size[i])))
    };
    let parts = [
        (!keeps_frames, "the numbers of frames"),
        (
            !holds.names && any(&|camera| camera.name.is_some()),
            "the names of pictures",
        ),
        (!holds.view && has_view, "the lens"),
        (
            holds.view && !holds.pixels && of_lens(&|lens| lens.size.is_some()),
            SIZE,
        ),
        (
            holds.view && !holds.pixels && of_lens(&|lens| differs(lens.focal[0], lens.focal[1])),
            "focal lengths that differ across and down",
        ),
        (
            holds.view && !holds.center && of_lens(&is_off_center),
            "the shift of the lens",
        ),
        (holds.view && !holds.skew && of_lens(&|lens| lens.skew != 0.0), "skew"),
        (
            holds.view
                && of_lens(&|lens| lens.distortion != ViewDistortion::None && !(holds.distortion)(&lens.distortion)),
            "the distortion of the lens",
        ),
        (any(&|camera| camera.has_blur), "depth of field and shutters"),
    ];
    parts
        .into_iter()
        .filter(|(is_lost, _)| *is_lost)
        .map(|(_, part)| part)
        .collect()
}
