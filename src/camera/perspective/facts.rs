//! A perspective camera in the numbers of computer vision and of photographers.

use glam::{DMat3, DVec3};

use super::Perspective;
use crate::camera::{DepthOfField, LensFacts, PinholeView, StereoEye};

impl Perspective {
    /// The unit direction of the line of sight.
    pub(super) fn forward(&self) -> DVec3 {
        self.lens_axes[1].cross(self.lens_axes[0])
    }

    /// The camera of an eye beside this one. Its picture is shifted so that it shows the same at the convergence distance.
    pub(super) fn beside(&self, eye: &StereoEye) -> Self {
        let to_the_right = self.lens_axes[0] * eye.offset;
        Self {
            eye: self.eye + to_the_right,
            corner: eye
                .convergence
                .map_or(self.corner, |distance| self.corner - to_the_right / distance),
            ..*self
        }
    }

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
