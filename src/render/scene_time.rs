//! The times of a frame at which its scene is sought.

/// A time of a frame at which its scene is sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SceneTime {
    /// A fraction, from 0 to 1, of the time while the shutter is open.
    Shutter(f64),
    /// As the shutter of the frame before opens.
    Before,
    /// As the shutter of the next frame opens.
    After,
}

impl SceneTime {
    /// As the shutter opens.
    pub const OPENING: Self = Self::Shutter(0.0);
}
