//! Samplers: random numbers that are a function of their address.
//!
//! A number is addressed by (seed, frame, pixel, sample, dimension). There is no state, so threads,
//! tiles, crops, chunks of frames and resumed frames use the same numbers.

use std::ops::Range;

use crate::{
    kind::{kinds, named},
    math::{
        Dispatch, Vec2,
        hash::{unit_f32, unit_f64},
        warp::{self, Sample2D},
    },
    value::Problem,
};

pub mod independent;
pub mod sobol;

pub use independent::Independent;
pub use sobol::Sobol;

named! {
    /// Whether the noise changes from frame to frame.
    #[derive(Default)]
    pub enum SeedMode: "seed mode" {
        /// Every frame has its own random numbers.
        #[default]
        Frame = "frame",
        /// All frames use the same random numbers, so the noise of still parts does not change.
        Fixed = "fixed",
    }
}

impl SeedMode {
    /// Returns the frame whose random numbers frame `number` uses.
    pub const fn frame(self, number: i32) -> i32 {
        match self {
            Self::Frame => number,
            Self::Fixed => 0,
        }
    }
}

/// The address of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleKey {
    pub seed: u32,
    pub frame: i32,
    /// Column and row in the full picture, regardless of the crop.
    pub pixel: [u32; 2],
    pub sample: u32,
}

/// The addresses of many samples of one frame, as arrays.
#[derive(Clone, Debug, Default)]
pub struct SampleKeys {
    pub seed: u32,
    pub frame: i32,
    pub columns: Vec<u32>,
    pub rows: Vec<u32>,
    pub samples: Vec<u32>,
}

impl SampleKeys {
    /// Clears the samples and sets the `seed` and the `frame` of those to come.
    pub fn start(&mut self, seed: u32, frame: i32) {
        (self.seed, self.frame) = (seed, frame);
        self.columns.clear();
        self.rows.clear();
        self.samples.clear();
    }

    /// Appends samples of one pixel.
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

    /// Returns the address of sample `i`.
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

/// Three dimensions of a sample: a pair of numbers, and a third one, which is well distributed together with them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension(pub u32);

impl Dimension {
    /// Position on the film; the third number is the time between the shutter's opening and closing.
    pub const FILM: Self = Self(0);
    /// Position on the lens.
    pub const LENS: Self = Self(1);

    /// Returns the dimensions of a use at the vertex that ends segment `depth`, 1 for a camera ray.
    pub const fn at(depth: u32, sample_use: SampleUse) -> Self {
        Self(2 + SampleUse::COUNT * (depth - 1) + sample_use as u32)
    }

    /// Returns the dimension that chooses a material of a mixture at the vertex that ends segment `depth` (x). These dimensions lie
    /// between those of all uses and those of transparency.
    pub const fn mixture(depth: u32) -> Self {
        Self(1 << 30 | (depth & 0xffff))
    }

    /// Returns the dimension that decides whether segment `depth` passes its `count`th partly
    /// transparent surface (x). These dimensions lie beyond all others and are for [`Independent`]
    /// only.
    pub const fn transparency(depth: u32, count: u32) -> Self {
        Self(1 << 31 | (depth & 0x7fff) << 16 | (count & 0xffff))
    }
}

/// The uses of random numbers at a vertex of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum SampleUse {
    /// Point on a lamp or a sun; the third number selects the light.
    Light,
    /// Direction of a lobe; the third number selects the lobe.
    Bsdf,
    /// Russian roulette (x).
    Roulette,
    /// Direction of the background.
    Background,
}

impl SampleUse {
    const COUNT: u32 = 4;

    /// All uses, in the order of their dimensions.
    pub const ALL: [Self; Self::COUNT as usize] = [Self::Light, Self::Bsdf, Self::Roulette, Self::Background];
}

/// A uniform number in `[0, 1)` of 32 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UnitBits(pub u32);

impl UnitBits {
    /// The number, rounded down.
    #[inline(always)]
    pub const fn f32(self) -> f32 {
        unit_f32(self.0)
    }

    /// The number with all its bits, for choices among very many.
    #[inline(always)]
    pub const fn f64(self) -> f64 {
        unit_f64(self.0)
    }
}

/// Where the numbers of many samples go.
pub struct Filled<'a> {
    pub pairs: &'a mut Vec<Vec2>,
    /// `None` if the third numbers are not needed.
    pub thirds: Option<&'a mut Vec<UnitBits>>,
}

/// Numbers that are drawn for all vertices of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draw {
    pub sample_use: SampleUse,
    /// Whether the third number is drawn, too.
    pub third: bool,
}

/// The random numbers of one path.
#[derive(Clone, Copy, Debug)]
pub struct PathSampler<'a> {
    pub sampler: &'a Sampler,
    /// The addresses of a batch of samples, and the numbers that were generated for them.
    pub keys: &'a SampleKeys,
    pub batch: &'a SampleBatch,
    /// The index of the path in the batch.
    pub index: usize,
}

impl PathSampler<'_> {
    /// Returns two random numbers in `[0, 1)`.
    #[inline]
    pub fn get_2d(&self, dimension: Dimension) -> Vec2 {
        match self.batch.get(dimension) {
            Some(pairs) => pairs[self.index],
            None => self.draw(dimension).0,
        }
    }

    /// Returns the third number of the dimension.
    #[inline]
    pub fn get_third(&self, dimension: Dimension) -> UnitBits {
        match self.batch.get_thirds(dimension) {
            Some(thirds) => thirds[self.index],
            None => self.draw(dimension).1,
        }
    }

    /// Returns the numbers of a dimension that the batch does not have. It is not inlined: every BSDF would have a copy.
    #[inline(never)]
    fn draw(&self, dimension: Dimension) -> (Vec2, UnitBits) {
        self.sampler.get_3d(&self.keys.get(self.index), dimension)
    }

    /// Returns two random numbers in `[0, 1)` for a direction, with their point on the unit disk.
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

/// Random numbers of many vertices, generated together so that their latencies overlap.
#[derive(Debug, Default)]
pub struct SampleBatch {
    /// The first dimension of the vertices, and the numbers of the dimensions from there on.
    first: u32,
    pairs: [Vec<Vec2>; SampleUse::COUNT as usize],
    thirds: [Vec<UnitBits>; SampleUse::COUNT as usize],
    /// The points on the unit disk of the numbers for directions.
    disks: Vec<Vec2>,
    /// One bit for each dimension whose pairs were generated, and whose third numbers were.
    generated: u8,
    generated_thirds: u8,
}

impl SampleBatch {
    /// Generates the numbers of `draws` for all samples in `keys`, at vertices whose first dimension
    /// is `first`.
    pub fn generate(
        &mut self,
        on: impl Dispatch,
        sampler: &Sampler,
        keys: &SampleKeys,
        first: Dimension,
        draws: &[Draw],
    ) {
        self.first = first.0;
        self.clear();
        for &Draw { sample_use, third } in draws {
            let k = sample_use as u32;
            self.generated |= 1 << k;
            self.generated_thirds |= u8::from(third) << k;
            let numbers = Filled {
                pairs: &mut self.pairs[k as usize],
                thirds: third.then_some(&mut self.thirds[k as usize]),
            };
            sampler.fill(on, keys, Dimension(first.0 + k), numbers);
            if sample_use == SampleUse::Bsdf {
                warp::squares_to_disk(on, &self.pairs[k as usize], &mut self.disks);
            }
        }
    }

    /// Clears the batch.
    pub fn clear(&mut self) {
        (self.generated, self.generated_thirds) = (0, 0);
    }

    /// Returns the third numbers of a use at the vertices, if they were generated.
    pub fn thirds_of(&self, sample_use: SampleUse) -> Option<&[UnitBits]> {
        self.get_thirds(Dimension(self.first + sample_use as u32))
    }

    /// Returns the numbers of a use at the vertices, if they were generated.
    pub fn of(&self, sample_use: SampleUse) -> Option<&[Vec2]> {
        self.get(Dimension(self.first + sample_use as u32))
    }

    /// Returns the points on the unit disk of the numbers for directions, if they were generated.
    pub fn disks(&self) -> Option<&[Vec2]> {
        (self.generated >> SampleUse::Bsdf as u32 & 1 == 1).then_some(&*self.disks)
    }

    /// Returns the numbers of `dimension`, if they were generated.
    #[inline]
    fn get(&self, dimension: Dimension) -> Option<&[Vec2]> {
        let i = dimension.0.wrapping_sub(self.first);
        (i < SampleUse::COUNT && self.generated >> i & 1 == 1).then(|| &*self.pairs[i as usize])
    }

    /// Returns the third numbers of `dimension`, if they were generated.
    #[inline]
    fn get_thirds(&self, dimension: Dimension) -> Option<&[UnitBits]> {
        let i = dimension.0.wrapping_sub(self.first);
        (i < SampleUse::COUNT && self.generated_thirds >> i & 1 == 1).then(|| &*self.thirds[i as usize])
    }
}

kinds! {
    /// The closed set of samplers.
    #[derive(serde::Serialize)]
    enum Sampler / SamplerDesc {
        "sobol" => Sobol(sobol::Sobol, sobol::SobolDesc),
        "independent" => Independent(independent::Independent, independent::IndependentDesc),
    }
    described only {}
    compiled by fn compile(&self, samples: u32) -> Result<Sampler, Problem>;
    /// Returns two random numbers in `[0, 1)`.
    fn get_2d(&self, key: &SampleKey, dimension: Dimension) -> Vec2;
    /// Returns the same two numbers and the third one.
    fn get_3d(&self, key: &SampleKey, dimension: Dimension) -> (Vec2, UnitBits);
    /// Replaces the contents of `numbers` with those of all `keys`.
    fn fill(&self, on: impl Dispatch, keys: &SampleKeys, dimension: Dimension, numbers: Filled<'_>);
}

impl Sampler {
    /// The default sampler, for `samples` samples of each pixel.
    pub fn default_for(samples: u32) -> Self {
        Self::Sobol(Sobol::new(samples))
    }

    /// The name of the sampler in scene files.
    pub fn name(&self) -> &'static str {
        SamplerDesc::NAMES[self.kind()]
    }
}

#[cfg(test)]
mod tests;
