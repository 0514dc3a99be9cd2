//! The records of a reconstruction that is written.

use super::model::CameraModel;
use crate::{
    assets::camera_path::{keys::Intrinsics, still::Still},
    camera::ViewDistortion,
};

/// A camera that is written.
pub struct WrittenCamera {
    pub model: &'static CameraModel,
    pub size: [f64; 2],
    pub parameters: Vec<f64>,
}

/// A picture that is written, in COLMAP's order of numbers.
pub struct Shot {
    /// `w, x, y, z` and the translation.
    pub pose: [f64; 7],
    /// An index into [`Reconstruction::cameras`].
    pub camera: usize,
    pub name: String,
}

/// A reconstruction that is written. Cameras and pictures have numbers from 1.
pub struct Reconstruction {
    pub cameras: Vec<WrittenCamera>,
    pub shots: Vec<Shot>,
}

impl Reconstruction {
    /// # Errors
    /// A camera has no lens in pixels, or no size.
    pub fn new(cameras: &[Still]) -> Result<Self, String> {
        let (mut lenses, mut shots) = (Vec::<&Intrinsics>::new(), Vec::new());
        for still in cameras {
            let lens = still.lens("colmap")?;
            // Intrinsics of turned cameras differ in their last digits only, and the cameras are one.
            let camera = lenses.iter().position(|other| other.is_near(lens)).unwrap_or_else(|| {
                lenses.push(lens);
                lenses.len() - 1
            });
            let (rotation, translation) = still.extrinsics();
            let [x, y, z, w] = rotation.to_array();
            let [tx, ty, tz] = translation.to_array();
            let name = still.name.clone().unwrap_or_else(|| format!("{:04}.png", still.frame));
            let name = name.replace(|c: char| c.is_control(), "_");
            shots.push(Shot {
                pose: [w, x, y, z, tx, ty, tz],
                camera,
                name,
            });
        }
        let cameras = lenses.into_iter().map(WrittenCamera::new).collect::<Result<_, _>>()?;
        Ok(Self { cameras, shots })
    }
}

impl WrittenCamera {
    fn new(lens: &Intrinsics) -> Result<Self, String> {
        let size = lens
            .size
            .ok_or("colmap files have the size of pictures: say it (--resolution)")?;
        let (name, coefficients) = match lens.distortion {
            ViewDistortion::None => ("PINHOLE", Vec::new()),
            ViewDistortion::OpenCvFisheye(k) => ("OPENCV_FISHEYE", k.to_vec()),
            ViewDistortion::OpenCv(k) if k[4..8] == [0.0; 4] => ("OPENCV", k[..4].to_vec()),
            ViewDistortion::OpenCv(k) => ("FULL_OPENCV", k[..8].to_vec()),
        };
        let center = lens.center.map(Option::unwrap_or_default);
        Ok(Self {
            model: CameraModel::by_name(name).expect("the table has the row"),
            size,
            parameters: [&lens.focal[..], &center, &coefficients].concat(),
        })
    }
}
