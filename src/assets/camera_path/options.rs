//! Options for reading a camera path.

use crate::camera::{Pose, RotationOrder};

/// Settings for reading a camera path file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraPathOptions {
    /// Frames per second, above 0, to convert times to frames.
    pub fps: Option<f64>,
    /// The order of rotation angles. It takes precedence over the file's own.
    pub rotation_order: Option<RotationOrder>,
    /// The pose of the scene's camera, for files that have a lens only.
    pub pose: Option<Pose>,
}
