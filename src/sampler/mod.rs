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
    /// When between the shutter's opening and closing (x).
    pub const TIME: Self = Self(2);

    /// What the vertex at the end of segment `depth` (1 for a camera ray) draws for.
    pub const fn at(depth: u32, purpose: Purpose) -> Self {
        Self(3 + Purpose::COUNT * (depth - 1) + purpose as u32)
    }

    /// Whether segment `depth` passes the `count`th surface that lets a part of the light through (x). Beyond all others,
    /// for [`Independent`] alone.
    pub const fn passing(depth: u32, count: u32) -> Self {
        Self(1 << 31 | (depth & 0x7fff) << 16 | (count & 0xffff))
    }
}

/// What the vertex of a path needs random numbers for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Purpose {
    /// Which light (x) and which lobe of the surface (y).
    Choice,
    /// Where on the light.
    Light,
    /// Which direction from the lobe.
    Bsdf,
    /// Whether the path survives (x).
    Survival,
}

impl Purpose {
    const COUNT: u32 = 4;
}

/// The random numbers of one sample.
#[derive(Clone, Copy, Debug)]
pub struct Numbers<'a> {
    pub sampler: &'a Sampler,
    pub key: SampleKey,
}

impl Numbers<'_> {
    /// Two numbers in `[0, 1)`.
    #[inline]
    pub fn pair(&self, dimension: Dimension) -> Vec2 {
        self.sampler.pair(&self.key, dimension)
    }
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
