//! The colours of patterns whose values lie between two.

use crate::math::Rgb;

/// The colours at the values 0 and 1.
#[derive(Clone, Copy, Debug)]
pub struct TwoColors(pub [Rgb; 2]);

impl TwoColors {
    /// The colour at a value, for each channel.
    #[inline]
    pub fn at(self, value: Rgb) -> Rgb {
        let Self([a, b]) = self;
        a + (b - a) * value
    }

    /// The mean difference of the colours over the channels: the standard deviation of a colour per that of its value.
    pub fn contrast(self) -> f32 {
        let Self([a, b]) = self;
        (b - a).map(f32::abs).mean()
    }

    pub fn max(self) -> Rgb {
        let Self([a, b]) = self;
        a.max(b)
    }
}
