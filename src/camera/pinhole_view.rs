//! A camera in the numbers of computer vision.

use glam::{DMat3, DMat4, DVec3, DVec4};

use super::{FilmSize, ViewMatrices, facts};

/// The place and the intrinsics of a pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinholeView {
    /// In m.
    pub eye: DVec3,
    /// Unit vectors to the right, up and backwards: from camera to world.
    pub axes: DMat3,
    /// The focal lengths across and down, in pixels.
    pub focal: [f64; 2],
    /// The point of the film on the line of sight, in pixels from the top left corner; pixel centres are at .5.
    pub center: [f64; 2],
}

impl PinholeView {
    /// The matrices from the world to the camera and to a picture of this size.
    pub(super) fn matrices(&self, film: FilmSize) -> ViewMatrices {
        let DMat3 { x_axis, y_axis, z_axis } = self.axes;
        let camera_from_world = facts::camera_from_world(self.eye, [x_axis, y_axis, -z_axis]);
        let ([fx, fy], [cx, cy]) = (self.focal, self.center);
        let [width, height] = film.map(|n| f64::from(n.max(1)));
        let ndc_from_camera = DMat4::from_cols(
            DVec4::new(fx / width, 0.0, 0.0, 0.0),
            DVec4::new(0.0, -fy / height, 0.0, 0.0),
            DVec4::new(cx / width, cy / height, 1.0, 1.0),
            DVec4::new(0.0, 0.0, -1.0, 0.0),
        );
        ViewMatrices {
            camera_from_world,
            ndc_from_world: Some(ndc_from_camera * camera_from_world),
        }
    }
}

/// The distortion of a camera, as data sets say it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ViewDistortion {
    #[default]
    None,
    /// `k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4` of OpenCV.
    OpenCv([f64; 12]),
    /// `k1, k2, k3, k4` of OpenCV's `fisheye`.
    OpenCvFisheye([f64; 4]),
}

/// A camera as data sets say it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibratedView {
    pub view: PinholeView,
    pub distortion: ViewDistortion,
}
