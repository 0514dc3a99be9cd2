//! The times at which a camera takes a picture: its shutter, and the readout of its sensor.

use serde::{Deserialize, Serialize};

use super::FilmSize;
use crate::math::track::{Channel, Segment};

/// The time while the shutter is open, in frames relative to the frame's number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shutter {
    pub open: f64,
    /// At least `open`; equal means no motion blur.
    pub close: f64,
}

/// The readout of a sensor with a rolling shutter: its lines are exposed one after the other, each for the time of the shutter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Readout {
    /// The time from the first edge of the picture to the last one, in frames, at least 0; 0 is a global shutter.
    pub time: f64,
    pub direction: ReadoutDirection,
}

/// The direction in which the lines of a sensor are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ReadoutDirection {
    #[default]
    TopToBottom,
    BottomToTop,
    LeftToRight,
    RightToLeft,
}

/// The times at which a camera takes the picture of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    pub shutter: Shutter,
    pub readout: Readout,
}

/// The longest readout of a sensor, in frames.
pub const MAX_READOUT: f64 = 100.0;

impl ReadoutDirection {
    /// Whether the lines that are read together are columns.
    pub fn reads_columns(self) -> bool {
        matches!(self, Self::LeftToRight | Self::RightToLeft)
    }
}

impl Readout {
    /// Whether all lines are exposed at the same time.
    pub fn is_global(&self) -> bool {
        self.time == 0.0
    }

    /// The time after the first edge of the picture, as a fraction of the whole readout, at which the line through a place of the
    /// film (in pixels) is read. Beyond the picture the lines are read with those at its edges.
    pub fn fraction(&self, [x, y]: [f64; 2], film: FilmSize) -> f64 {
        let [right, down] = [x / f64::from(film[0]), y / f64::from(film[1])].map(|at| at.clamp(0.0, 1.0));
        match self.direction {
            ReadoutDirection::TopToBottom => down,
            ReadoutDirection::BottomToTop => 1.0 - down,
            ReadoutDirection::LeftToRight => right,
            ReadoutDirection::RightToLeft => 1.0 - right,
        }
    }
}

impl Timing {
    /// The keys of scene files that give it.
    pub const KEYS: &[&str] = &["shutter", "readout", "readout_direction"];

    /// The time from the opening of the shutter for the first line until it closes for the last one, in frames.
    pub fn duration(&self) -> f64 {
        self.exposure() + self.readout.time
    }

    /// The time while a line is exposed, in frames; 0 without motion blur.
    pub fn exposure(&self) -> f64 {
        self.shutter.close - self.shutter.open
    }

    /// The time as a fraction of [`Timing::duration`], at the fraction `exposed` of the exposure of the line that is read at the
    /// fraction `read` of the readout.
    pub fn fraction(&self, exposed: f64, read: f64) -> f64 {
        let duration = self.duration();
        match self.readout.is_global() {
            true => exposed,
            false => ((exposed * self.exposure() + read * self.readout.time) / duration).clamp(0.0, 1.0),
        }
    }
}

/// The time while the picture of one frame is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShutterInterval {
    pub frame: f64,
    pub timing: Timing,
    /// The limits of the shot that the frame belongs to; the camera does not move beyond them.
    pub begin: f64,
    pub end: f64,
    /// Whether the camera stands still while the picture is taken.
    pub rests: bool,
}

impl ShutterInterval {
    /// Returns the time in frames at which the camera is at the fraction `u`, from 0 to 1, of the interval.
    pub fn time(&self, u: f64) -> f64 {
        if self.rests {
            return self.frame;
        }
        let open = self.timing.shutter.open;
        (self.frame + (open + self.timing.duration() * u)).clamp(self.begin, self.end)
    }
}

impl From<Shutter> for Timing {
    /// A global shutter.
    fn from(shutter: Shutter) -> Self {
        Self {
            shutter,
            readout: Readout::default(),
        }
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
