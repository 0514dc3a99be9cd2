//! Options for reading a camera path.

use crate::camera::RotationOrder;

/// Settings that a camera path file does not hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraPathOptions {
    /// Frames per second, above 0: what makes frames of times in seconds.
    pub fps: Option<f64>,
    /// The order of rotation angles. It goes before what the file says.
    pub rotation_order: Option<RotationOrder>,
}
