//! Samplers: the random numbers of a sample, by its address alone.
//!
//! A number is addressed by (seed, frame, pixel, sample, dimension). Nothing is drawn in turn, so threads, tiles,
//! crops, chunks of frames and resumed frames see the same numbers.

use std::ops::Range;

use serde::Deserialize;

use crate::{
    kind::kinds,
    math::{
        Runner, Vec2,
        warp::{self, Sample2D},
    },
    value::Problem,
};

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

/// Many samples of one picture, as arrays.
#[derive(Clone, Debug, Default)]
pub struct SampleKeys {
    pub seed: u32,
    pub frame: i32,
    pub columns: Vec<u32>,
    pub rows: Vec<u32>,
    pub samples: Vec<u32>,
}

impl SampleKeys {
    /// Begins anew with samples of the picture of `seed` and `frame`.
    pub fn start(&mut self, seed: u32, frame: i32) {
        (self.seed, self.frame) = (seed, frame);
        self.columns.clear();
        self.rows.clear();
        self.samples.clear();
    }

    /// Adds samples of one pixel.
    pub fn push(&mut self, [column, row]: [u32; 2], samples: Range<u32>) {
        self.samples.extend(samples);
        self.columns.resize(self.samples.len(), column);
        self.rows.resize(self.samples.len(), row);
    }

    pub fn len(&self) -> usize {
        self.samples.len()
    }

    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// The `i`th.
    #[inline]
    pub fn get(&self, i: usize) -> SampleKey {
        SampleKey {
            seed: self.seed,
            frame: self.frame,
            pixel: [self.columns[i], self.rows[i]],
            sample: self.samples[i],
        }
    }
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
    pub const fn at(depth: u32, sample_use: SampleUse) -> Self {
        Self(3 + SampleUse::COUNT * (depth - 1) + sample_use as u32)
    }

    /// Whether segment `depth` passes the `count`th surface that lets a part of the light through (x). Beyond all others,
    /// for [`Independent`] alone.
    pub const fn transparency(depth: u32, count: u32) -> Self {
        Self(1 << 31 | (depth & 0x7fff) << 16 | (count & 0xffff))
    }
}

/// What the vertex of a path needs random numbers for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum SampleUse {
    /// Which light (x) and which lobe of the surface (y).
    Selection,
    /// Where on the light.
    Light,
    /// Which direction from the lobe.
    Bsdf,
    /// Whether the path survives (x).
    Roulette,
}

impl SampleUse {
    const COUNT: u32 = 4;

    /// All, in their order.
    pub const ALL: [Self; Self::COUNT as usize] = [Self::Selection, Self::Light, Self::Bsdf, Self::Roulette];
}

/// The random numbers of one sample.
#[derive(Clone, Copy, Debug)]
pub struct PathSampler<'a> {
    pub sampler: &'a Sampler,
    /// Of some samples, and what is drawn for them already.
    pub keys: &'a SampleKeys,
    pub batch: &'a SampleBatch,
    /// Which of them.
    pub index: usize,
}

impl PathSampler<'_> {
    /// Two numbers in `[0, 1)`.
    #[inline]
    pub fn get_2d(&self, dimension: Dimension) -> Vec2 {
        match self.batch.get(dimension) {
            Some(pairs) => pairs[self.index],
            None => self.sampler.get_2d(&self.keys.get(self.index), dimension),
        }
    }

    /// Two numbers in `[0, 1)` for a direction.
    #[inline]
    pub fn get_sample_2d(&self, dimension: Dimension) -> Sample2D {
        match self.batch.get(dimension) {
            Some(squares) if dimension.0 == self.batch.first + SampleUse::Bsdf as u32 => Sample2D {
                square: squares[self.index],
                disk: self.batch.disks[self.index],
            },
            _ => self.get_2d(dimension).into(),
        }
    }
}

/// Numbers of many vertices, drawn at once: so the steps of one need not wait for those of another.
#[derive(Debug, Default)]
pub struct SampleBatch {
    /// The vertices' first dimension, and the pairs from there on.
    first: u32,
    pairs: [Vec<Vec2>; SampleUse::COUNT as usize],
    /// Of the pairs for directions: the points of the unit disk that they are.
    disks: Vec<Vec2>,
    /// One bit for each dimension that was drawn for.
    generated: u8,
}

impl SampleBatch {
    /// Draws for `uses` at vertices whose first dimension is `first`, for all samples in `keys`.
    pub fn generate(
        &mut self,
        on: impl Runner,
        sampler: &Sampler,
        keys: &SampleKeys,
        first: Dimension,
        uses: &[SampleUse],
    ) {
        self.first = first.0;
        self.generated = 0;
        for &sample_use in uses {
            let k = sample_use as u32;
            self.generated |= 1 << k;
            sampler.fill_2d(on, keys, Dimension(first.0 + k), &mut self.pairs[k as usize]);
            if sample_use == SampleUse::Bsdf {
                warp::squares_to_disk(on, &self.pairs[k as usize], &mut self.disks);
            }
        }
    }

    /// Forgets what was drawn.
    pub fn clear(&mut self) {
        self.generated = 0;
    }

    /// What was drawn for `dimension`.
    #[inline]
    fn get(&self, dimension: Dimension) -> Option<&[Vec2]> {
        let i = dimension.0.wrapping_sub(self.first);
        (i < SampleUse::COUNT && self.generated >> i & 1 == 1).then(|| &*self.pairs[i as usize])
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
    fn get_2d(&self, key: &SampleKey, dimension: Dimension) -> Vec2;
    /// The same for each of `keys`, in place of what `out` held.
    fn fill_2d(&self, on: impl Runner, keys: &SampleKeys, dimension: Dimension, out: &mut Vec<Vec2>);
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
