//! A perspective camera in the numbers of computer vision and of photographers.

use glam::{DMat3, DMat4, DVec3, DVec4};

use super::Perspective;
use crate::camera::{DepthOfField, FilmSize, LensFacts, ViewMatrices, facts};

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

impl Perspective {
    /// The camera seen through the middle of its lens.
    pub(super) fn view(&self) -> PinholeView {
        let [right, up] = self.lens_axes;
        let place = |axis: DVec3| -self.corner.dot(axis) / axis.length_squared();
        PinholeView {
            eye: self.eye,
            axes: DMat3::from_cols(right, up, -self.forward()),
            focal: [self.right.length().recip(), self.down.length().recip()],
            center: [place(self.right), place(self.down)],
        }
    }

    /// The lens in the terms of photographers.
    pub(super) fn facts(&self) -> LensFacts {
        let diameter = 2000.0 * self.lens_radius;
        LensFacts {
            focal_length: self.focal_length,
            depth_of_field: (diameter > 0.0).then(|| DepthOfField {
                fstop: self.focal_length / diameter,
                focus_distance: self.focus_distance,
            }),
        }
    }
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
