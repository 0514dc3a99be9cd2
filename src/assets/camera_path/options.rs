//! What is said about a camera path besides its file.

use crate::camera::RotationOrder;

/// What the file does not say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraPathOptions {
    /// Frames per second, above 0: what makes frames of times in seconds.
    pub fps: Option<f64>,
    /// The order of rotation angles. It goes before what the file says.
    pub rotation_order: Option<RotationOrder>,
}
