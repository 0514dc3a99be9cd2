//! Motion vectors of a frame.

use super::signal::Color;

/// The motion of the surface that each pixel shows: pixels to the right, pixels upwards, and metres
/// of depth; 0 where it is unknown.
#[derive(Clone, Debug, Default)]
pub struct Vectors {
    /// From the frame before to this one.
    pub backward: Color,
    /// From this frame to the next one.
    pub forward: Color,
}

impl Vectors {
    /// The motion of pixel `i` to the next frame, or to the one before.
    pub(super) fn away(&self, is_later: bool, i: usize) -> [f32; 3] {
        match is_later {
            true => self.forward.each_ref().map(|plane| plane[i]),
            false => self.backward.each_ref().map(|plane| -plane[i]),
        }
    }

    /// The motion that led to pixel `i`, if the frame was reached in this direction.
    pub(super) fn arrival(&self, is_later: bool, i: usize) -> [f32; 3] {
        self.away(!is_later, i).map(|v| -v)
    }
}
