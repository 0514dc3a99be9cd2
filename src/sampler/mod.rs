//! Samplers: the random numbers of a sample, by its address alone.
//!
//! A number is addressed by (seed, frame, pixel, sample, dimension). Nothing is drawn in turn, so threads, tiles,
//! crops, chunks of frames and resumed frames see the same numbers.

use crate::math::Vec2;

pub mod independent;

pub use independent::Independent;

/// Which sample of which picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleKey {
    pub seed: u32,
    pub frame: i32,
    /// Column and row in the full picture, whatever is cropped.
    pub pixel: [u32; 2],
    pub sample: u32,
}

/// A pair of dimensions of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension(pub u32);

impl Dimension {
    /// Where in its pixel a sample lies.
    pub const FILM: Self = Self(0);
    /// Where on the lens.
    pub const LENS: Self = Self(1);
}

/// The closed set of samplers.
#[derive(Clone, Copy, Debug)]
pub enum Sampler {
    Independent(Independent),
}

impl Sampler {
    /// Two numbers in `[0, 1)`.
    #[inline]
    pub fn pair(&self, key: &SampleKey, dimension: Dimension) -> Vec2 {
        match self {
            Self::Independent(s) => s.pair(key, dimension),
        }
    }
}
