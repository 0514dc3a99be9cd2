//! The pinhole of a perspective camera, in the numbers of computer vision.

use glam::{DMat3, DVec3};

use super::Perspective;

/// The place and the intrinsics of a pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinholeView {
    /// In m.
    pub eye: DVec3,
    /// Unit vectors to the right, up and backwards: from camera to world.
    pub axes: DMat3,
    /// The focal lengths across and down, in pixels.
    pub focal: [f64; 2],
    /// The place on the film that the line of sight meets, in pixels from the top left corner, so that pixel centres are at .5.
    pub center: [f64; 2],
}

impl Perspective {
    /// The camera seen through the middle of its lens.
    pub fn pinhole(&self) -> PinholeView {
        let [right, up] = self.lens_axes;
        let place = |axis: DVec3| -self.corner.dot(axis) / axis.length_squared();
        PinholeView {
            eye: self.eye,
            axes: DMat3::from_cols(right, up, -self.forward()),
            focal: [self.right.length().recip(), self.down.length().recip()],
            center: [place(self.right), place(self.down)],
        }
    }
}
