//! The facts about a camera that files tell: matrices from the world to the picture, and the lens.

use glam::{DMat4, DVec3, DVec4};

/// The matrices from the world, in m, to the camera and to the picture.
///
/// Their spaces are those of OpenEXR's standard attributes (and of RenderMan): the camera's is left-handed, with x to the right,
/// y up and z along the line of sight; the picture's goes from (0, 0) in the upper left corner of the full frame to (1, 1)
/// in the lower right one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewMatrices {
    pub camera_from_world: DMat4,
    /// Projective: x and y are to be divided by w. `None` for cameras that bend straight lines.
    pub ndc_from_world: Option<DMat4>,
}

/// A lens in the terms of photographers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensFacts {
    /// In mm.
    pub focal_length: f64,
    /// `None` for a pinhole.
    pub depth_of_field: Option<DepthOfField>,
}

/// The settings of a lens with an aperture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthOfField {
    /// The focal length over the diameter of the aperture.
    pub fstop: f64,
    /// In m.
    pub focus_distance: f64,
}

/// The matrix to a camera at `eye` with these unit axes.
pub(super) fn camera_from_world(eye: DVec3, [right, up, forward]: [DVec3; 3]) -> DMat4 {
    let row = |axis: DVec3| axis.extend(-axis.dot(eye));
    DMat4::from_cols(row(right), row(up), row(forward), DVec4::W).transpose()
}
