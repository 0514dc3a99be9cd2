//! Samplers: the random numbers of a sample, by its address alone.
//!
//! A number is addressed by (seed, frame, pixel, sample, dimension). Nothing is drawn in turn, so threads, tiles,
//! crops, chunks of frames and resumed frames see the same numbers.

use serde::Deserialize;

use crate::{kind::kinds, math::Vec2, value::Problem};

pub mod independent;
pub mod sobol;

pub use independent::Independent;
pub use sobol::Sobol;

/// Whether the noise of a sequence moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SeedMode {
    /// Every frame has its own numbers.
    #[default]
    Frame,
    /// All frames have the same: what does not move keeps its noise.
    Fixed,
}

impl SeedMode {
    pub const ALL: [Self; 2] = [Self::Frame, Self::Fixed];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Frame => "frame",
            Self::Fixed => "fixed",
        }
    }

    /// The frame that the numbers of frame `number` are those of.
    pub const fn frame(self, number: i32) -> i32 {
        match self {
            Self::Frame => number,
            Self::Fixed => 0,
        }
    }
}

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

kinds! {
    /// The closed set of samplers.
    enum Sampler / SamplerDesc {
        "sobol" => Sobol(sobol::Sobol, sobol::SobolDesc),
        "independent" => Independent(independent::Independent, independent::IndependentDesc),
    }
    described only {}
    compiled by fn compile(&self, samples: u32) -> Result<Sampler, Problem>;
    /// Two numbers in `[0, 1)`.
    fn pair(&self, key: &SampleKey, dimension: Dimension) -> Vec2;
}

impl Sampler {
    /// What scenes have where they name none, for pictures of `samples` samples of each pixel.
    pub fn default_for(samples: u32) -> Self {
        Self::Sobol(Sobol::new(samples))
    }

    /// The name that scene files have for it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sobol(_) => SamplerDesc::NAMES[0],
            Self::Independent(_) => SamplerDesc::NAMES[1],
        }
    }
}

#[cfg(test)]
mod tests;
