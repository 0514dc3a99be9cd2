//! The shutter of a camera path: when it is open for a frame.

use crate::math::track::{Channel, Segment};

/// The time while the shutter is open, in frames relative to the frame's number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shutter {
    pub open: f64,
    /// At least `open`; equal means no motion blur.
    pub close: f64,
}

/// The time while the shutter is open for one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShutterInterval {
    pub(super) frame: f64,
    pub(super) shutter: Shutter,
    /// The limits of the shot that the frame belongs to; the camera does not move beyond them.
    pub(super) begin: f64,
    pub(super) end: f64,
}

impl ShutterInterval {
    /// Returns the time in frames at the fraction `u`, from 0 to 1, of the interval.
    pub fn time(&self, u: f64) -> f64 {
        let Shutter { open, close } = self.shutter;
        (self.frame + (open + (close - open) * u)).clamp(self.begin, self.end)
    }
}

impl Channel for Shutter {
    fn linear(from: Self, to: Self, u: f64) -> Self {
        Self {
            open: f64::linear(from.open, to.open, u),
            close: f64::linear(from.close, to.close, u),
        }
    }

    fn smooth(segment: &Segment<Self>, frame: f64) -> Self {
        let open = f64::smooth(&segment.map(|s| s.open), frame);
        let close = f64::smooth(&segment.map(|s| s.close), frame);
        Self {
            open,
            close: close.max(open),
        }
    }
}
