//! Keys of camera paths from the poses and the intrinsics that files give.

use std::collections::BTreeSet;

use glam::{DMat3, DQuat, DVec3};

use super::{PathProblem, PathProblems};
use crate::camera::{
    LensOverrides, ViewDistortion,
    path::{CameraPath, Interp, MAX_FRAME, Orientation, PathKey, Rotation},
    pinhole::PinholeLens,
};
use crate::{math::sorting, value::one_line};

/// The largest difference of a length from 1, and of a cosine from 0, in a rotation.
const UNIT_TOLERANCE: f64 = 1e-3;

/// A half turn about x: from a camera that looks along +z with +y down to one that looks along -z with +y up.
const FLIP: DQuat = DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0);

/// A camera of a file: it looks along its -z with +y up.
#[derive(Clone, Debug)]
pub struct Posed {
    pub eye: DVec3,
    /// From camera to world.
    pub rotation: DQuat,
    pub lens: LensOverrides,
    pub pinhole: Option<PinholeLens>,
    pub name: Option<String>,
}

impl Posed {
    pub fn new(eye: DVec3, rotation: DQuat) -> Self {
        Self {
            eye,
            rotation,
            lens: LensOverrides::default(),
            pinhole: None,
            name: None,
        }
    }

    /// The camera of computer vision at `eye`, which looks along its +z with +y down, by its rotation to the world.
    pub fn of_vision(eye: DVec3, rotation: DQuat) -> Self {
        Self::new(eye, rotation * FLIP)
    }

    /// The same by the map from the world to the camera.
    pub fn of_extrinsics(rotation: DQuat, translation: DVec3) -> Self {
        let to_world = rotation.conjugate();
        Self::of_vision(-(to_world * translation), to_world)
    }

    fn key(self, frame: f64) -> PathKey {
        PathKey {
            frame,
            eye: self.eye,
            orientation: Orientation::Rotation(Rotation::Quaternion(self.rotation)),
            lens: self.lens,
            pinhole: self.pinhole,
            shutter: None,
            readout: None,
            stereo: [None; 2],
            interp: Interp::Smooth,
            name: self.name,
        }
    }
}

/// Whether a position can be that of a camera.
pub fn is_place(p: DVec3) -> bool {
    p.to_array().iter().all(|v| v.abs() <= f64::from(f32::MAX))
}

/// A quaternion of unit length, or what is wrong with it.
pub fn unit_quaternion([x, y, z, w]: [f64; 4]) -> Result<DQuat, String> {
    let q = DQuat::from_xyzw(x, y, z, w);
    let length = q.length();
    let is_unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
    if !is_unit {
        return Err(format!(
            "the quaternion has length {length:.6}, expected 1 within {UNIT_TOLERANCE}"
        ));
    }
    Ok(q / length)
}

/// The rotation of a matrix, or what is wrong with it.
pub fn rotation(matrix: &DMat3) -> Result<DQuat, String> {
    let off = *matrix * matrix.transpose() - DMat3::IDENTITY;
    let worst = off.to_cols_array().iter().fold(0.0, |worst: f64, v| worst.max(v.abs()));
    if !(worst <= UNIT_TOLERANCE && matrix.determinant() > 0.0) {
        return Err(
            "the matrix is not a rotation: its rows must be right-handed unit vectors at right angles".to_owned(),
        );
    }
    Ok(DQuat::from_mat3(matrix).normalize())
}

/// Intrinsics in pixels.
#[derive(Clone, Copy, Debug)]
pub struct Intrinsics {
    pub focal: [f64; 2],
    pub center: [Option<f64>; 2],
    pub skew: f64,
    pub size: Option<[f64; 2]>,
    pub distortion: ViewDistortion,
}

impl Intrinsics {
    /// Whether all numbers agree but for rounding.
    pub fn is_near(&self, other: &Self) -> bool {
        let is_near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs().max(1.0);
        let center = self.center.map(Option::unwrap_or_default).into_iter();
        let numbers = self.focal.into_iter().chain(center).chain([self.skew]);
        let other_center = other.center.map(Option::unwrap_or_default).into_iter();
        let others = other.focal.into_iter().chain(other_center).chain([other.skew]);
        let is_same_model = (self.size, self.distortion) == (other.size, other.distortion);
        is_same_model && numbers.zip(others).all(|(a, b)| is_near(a, b))
    }

    /// The lens, or what is wrong with it.
    pub fn lens(self) -> Result<PinholeLens, String> {
        let Self {
            focal,
            center,
            skew,
            size,
            distortion,
        } = self;
        let is_long = |v: &f64| *v > 0.0 && *v <= f64::from(f32::MAX);
        if !focal.iter().all(is_long) {
            return Err(format!(
                "the focal lengths {} and {} are not above 0",
                focal[0], focal[1]
            ));
        }
        if let Some([width, height]) =
            size.filter(|size| !size.iter().all(|n| *n >= 1.0 && is_long(n) && n.fract() == 0.0))
        {
            return Err(format!(
                "the picture has {width}x{height} pixels, expected whole numbers above 0"
            ));
        }
        let coefficients: &[f64] = match &distortion {
            ViewDistortion::None => &[],
            ViewDistortion::OpenCv(all) => all,
            ViewDistortion::OpenCvFisheye(all) => all,
        };
        let mut numbers = coefficients.iter().chain(center.iter().flatten()).chain([&skew]);
        if numbers.any(|v| !v.is_finite()) {
            return Err("a number of the lens is not finite".to_owned());
        }
        Ok(PinholeLens {
            focal,
            center,
            skew,
            size,
            distortion: distortion.into(),
        })
    }
}

/// Whether frames of pictures are all that a path has, or positions on a way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frames {
    Pictures,
    Way,
}

/// The path of cameras with these frames.
pub fn path(cameras: impl IntoIterator<Item = (f64, Posed)>, frames: Frames) -> Result<CameraPath, PathProblems> {
    let mut keys: Vec<PathKey> = cameras.into_iter().map(|(frame, posed)| posed.key(frame)).collect();
    sorting::sort_by(&mut keys, |a, b| a.frame.total_cmp(&b.frame));
    let mut pairs = keys.iter().zip(keys.iter().skip(1));
    if let Some((_, second)) = pairs.find(|(first, second)| first.frame == second.frame) {
        let name = second.name.as_deref().unwrap_or_default();
        let message = format!(
            "two pictures are frame {}, one is `{}`",
            second.frame,
            one_line(name, 80)
        );
        return Err(PathProblem::of_file(message).into());
    }
    let path = CameraPath::new(&keys).map_err(|e| PathProblems::from(PathProblem::of_file(e.to_string())))?;
    Ok(match frames {
        Frames::Pictures => path.of_pictures(keys.iter().map(|key| key.frame as i64).collect()),
        Frames::Way => path,
    })
}

/// The frames of pictures: the last numbers of their names, if each has one of its own; else they are counted from 1.
pub fn picture_frames<'a>(names: impl ExactSizeIterator<Item = Option<&'a str>> + Clone) -> Vec<i64> {
    let count = names.len() as i64;
    let numbers: Option<Vec<i64>> = names.map(|name| name.and_then(last_number)).collect();
    let is_distinct = |numbers: &Vec<i64>| sorting::ordered::<_, BTreeSet<&i64>>(numbers).len() == numbers.len();
    numbers.filter(is_distinct).unwrap_or_else(|| (1..=count).collect())
}

/// The last number in a name without its ending.
fn last_number(name: &str) -> Option<i64> {
    let file = name.rsplit(['/', '\\']).next()?;
    let stem = file
        .rsplit_once('.')
        .map_or(file, |(stem, ending)| match ending.parse::<i64>() {
            // The number of `camera.0012`.
            Ok(_) => file,
            Err(_) => stem,
        });
    // A time in seconds.
    if stem.contains('.') && stem.parse::<f64>().is_ok() {
        return None;
    }
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end]
        .rfind(|c: char| !c.is_ascii_digit())
        .map_or(0, |i| i + stem[i..].chars().next().map_or(1, char::len_utf8));
    // A hyphen behind a word is none of the number: `f-0002` is frame 2, and `f.-002` is frame -2.
    let is_minus = |before: &str| before.is_empty() || before.ends_with(['.', '_', '-']);
    let start = match stem[..start].strip_suffix('-') {
        Some(before) if is_minus(before) => before.len(),
        _ => start,
    };
    let number = stem[start..end].parse::<i64>().ok();
    number.filter(|n| (-MAX_FRAME..=MAX_FRAME).contains(n))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_numbers_of_their_own_are_those_frames() {
        let of = |names: &[&'static str]| picture_frames(names.iter().map(|name| Some(*name)));
        assert_eq!(of(&["images/f_0012.png", "images/f_0003.v2.jpg"]), [12, 2]);
        assert_eq!(of(&["camera.0012", "camera.0013"]), [12, 13]);
        assert_eq!(
            of(&["-002.png", "f_-001.png", "f.-0003.exr", "0000.png"]),
            [-2, -1, -3, 0]
        );
        assert_eq!(of(&["f-0012.png", "f-0003.png"]), [12, 3]);
        assert_eq!(of(&["a/1.png", "b/1.png"]), [1, 2]);
        assert_eq!(of(&["left.png", "7.png"]), [1, 2]);
        assert_eq!(of(&["é9é.png"]), [9]);
        assert_eq!(of(&["1311868164363181.png"]), [1]);
        assert_eq!(of(&["1305031102.175304.png", "1305031102.075326.png"]), [1, 2]);
    }

    #[test]
    fn a_camera_of_computer_vision_looks_along_z_with_y_down() {
        let posed = Posed::of_extrinsics(DQuat::IDENTITY, DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(posed.eye, DVec3::new(-1.0, -2.0, -3.0));
        assert_eq!(posed.rotation * DVec3::NEG_Z, DVec3::Z);
        assert_eq!(posed.rotation * DVec3::Y, DVec3::NEG_Y);
    }

    #[test]
    fn mirrors_and_scales_are_no_rotations() {
        assert!(rotation(&DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0))).is_err());
        assert!(rotation(&DMat3::from_diagonal(DVec3::splat(2.0))).is_err());
        assert!(rotation(&DMat3::from_diagonal(DVec3::splat(f64::NAN))).is_err());
        assert_eq!(rotation(&DMat3::IDENTITY), Ok(DQuat::IDENTITY));
    }
}
