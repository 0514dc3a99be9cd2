//! The camera models of COLMAP.

use super::record::Place;
use crate::{
    assets::camera_path::keys::Intrinsics,
    camera::{ViewDistortion, pinhole::PinholeLens},
};

/// The kind of distortion of a model. Its coefficients are the first ones of those that OpenCV has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    Plain,
    OpenCv,
    Fisheye,
    /// Other distortions, which are not rendered.
    Other,
}

/// A camera model: its number and its name, and the numbers of focal lengths and coefficients. Two
/// for the centre stand between these.
#[derive(Debug)]
pub struct CameraModel {
    pub number: i32,
    pub name: &'static str,
    pub focals: usize,
    pub coefficients: usize,
    pub family: Family,
}

const fn row(number: i32, name: &'static str, focals: usize, coefficients: usize, family: Family) -> CameraModel {
    CameraModel {
        number,
        name,
        focals,
        coefficients,
        family,
    }
}

/// All models.
pub const MODELS: [CameraModel; 18] = [
    row(0, "SIMPLE_PINHOLE", 1, 0, Family::Plain),
    row(1, "PINHOLE", 2, 0, Family::Plain),
    row(2, "SIMPLE_RADIAL", 1, 1, Family::OpenCv),
    row(3, "RADIAL", 1, 2, Family::OpenCv),
    row(4, "OPENCV", 2, 4, Family::OpenCv),
    row(5, "OPENCV_FISHEYE", 2, 4, Family::Fisheye),
    row(6, "FULL_OPENCV", 2, 8, Family::OpenCv),
    row(7, "FOV", 2, 1, Family::Other),
    row(8, "SIMPLE_RADIAL_FISHEYE", 1, 1, Family::Fisheye),
    row(9, "RADIAL_FISHEYE", 1, 2, Family::Fisheye),
    row(10, "THIN_PRISM_FISHEYE", 2, 8, Family::Other),
    row(11, "RAD_TAN_THIN_PRISM_FISHEYE", 2, 12, Family::Other),
    row(12, "SIMPLE_DIVISION", 1, 1, Family::Other),
    row(13, "DIVISION", 2, 1, Family::Other),
    row(14, "SIMPLE_FISHEYE", 1, 0, Family::Fisheye),
    row(15, "FISHEYE", 2, 0, Family::Fisheye),
    row(16, "EUCM", 2, 2, Family::Other),
    row(17, "EQUIRECTANGULAR", 0, 0, Family::Other),
];

impl CameraModel {
    pub fn by_name(name: &str) -> Option<&'static Self> {
        MODELS.iter().find(|model| model.name == name)
    }

    pub fn by_number(number: i32) -> Option<&'static Self> {
        MODELS.iter().find(|model| model.number == number)
    }

    /// The number of parameters.
    pub fn parameters(&self) -> usize {
        self.focals + 2 + self.coefficients
    }
}

/// A camera of a file.
pub struct FileCamera {
    pub place: Place,
    pub model: &'static CameraModel,
    pub size: [f64; 2],
    /// As many as the model has.
    pub parameters: Vec<f64>,
}

impl FileCamera {
    /// The lens, or what is wrong with it.
    pub fn lens(&self) -> Result<PinholeLens, String> {
        let (focals, rest) = self.parameters.split_at(self.model.focals);
        let (center, coefficients) = rest.split_at(2);
        let distortion = match self.model.family {
            Family::Plain => ViewDistortion::None,
            Family::OpenCv => ViewDistortion::OpenCv(padded(coefficients)),
            Family::Fisheye => ViewDistortion::OpenCvFisheye(padded(coefficients)),
            Family::Other => {
                let known: Vec<_> = MODELS.iter().filter(|model| model.family != Family::Other).collect();
                let names: Vec<_> = known.iter().map(|model| model.name).collect();
                return Err(format!(
                    "the camera model {} is not rendered, expected one of {}",
                    self.model.name,
                    names.join(", ")
                ));
            }
        };
        let first = focals[0];
        let intrinsics = Intrinsics {
            focal: [first, focals.get(1).copied().unwrap_or(first)],
            center: [Some(center[0]), Some(center[1])],
            skew: 0.0,
            size: Some(self.size),
            distortion,
        };
        intrinsics.lens()
    }
}

fn padded<const N: usize>(given: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| given.get(i).copied().unwrap_or(0.0))
}
