//! Blocks of area light samples, one light and one lit point in each lane, with the results of [`AreaSample`].

use super::{LightBlock, area::AreaSample};
use crate::{
    math::{
        Dispatch, Rgb, Sidedness, VectorLoop,
        block::{Each, LANES},
    },
    shape::{SampleBlock, SampledPoint},
};

/// Area lights, and the points that they light.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct AreaBlock {
    pub points: SampleBlock,
    radiance: Each<Rgb>,
    /// Not 0 if both sides emit.
    both_sides: Each<u32>,
}

impl Default for AreaBlock {
    fn default() -> Self {
        Self {
            points: SampleBlock::EMPTY,
            radiance: [Rgb::BLACK; LANES],
            both_sides: [0; LANES],
        }
    }
}

impl AreaBlock {
    /// Sets the emission of a lane: its radiance in W m^-2 sr^-1, and the sides that emit.
    #[inline(always)]
    pub fn set_emission(&mut self, lane: usize, radiance: Rgb, sidedness: Sidedness) {
        self.radiance[lane] = radiance;
        self.both_sides[lane] = u32::from(sidedness == Sidedness::Both);
    }

    /// Samples the lights of all lanes and writes the samples to `to`.
    #[inline]
    pub fn sample(&mut self, on: impl Dispatch, to: &mut LightBlock) {
        self.points.sample(on);
        on.dispatch(Arrivals { block: self, to });
        to.li = self.radiance;
    }
}

/// Computes the directions and distances to the sampled points.
struct Arrivals<'a> {
    block: &'a AreaBlock,
    to: &'a mut LightBlock,
}

impl VectorLoop for Arrivals<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { block, to } = self;
        // Results go to local arrays, so that the compiler knows that reads and writes do not alias.
        let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let (mut distances, mut densities, mut kinds) = ([0.0; LANES], [0.0; LANES], [0; LANES]);
        for i in 0..LANES {
            let from = block.points.from(i);
            let SampledPoint {
                p, p_error, ng, pdf, ..
            } = block.points.point(i);
            let sample = AreaSample { p, p_error, ng, pdf };
            let (wi, distance) = sample.direction(from);
            let shines = (sample.front_cos(from) > 0.0) | (block.both_sides[i] != 0);
            let arrives = shines & (pdf > 0.0) & pdf.is_finite() & (distance > 0.0);
            (x[i], y[i], z[i]) = (wi.x, wi.y, wi.z);
            (distances[i], densities[i]) = (distance, pdf);
            kinds[i] = if arrives { LightBlock::AREA } else { LightBlock::NONE };
        }
        to.wi = [x, y, z];
        (to.distance, to.pdf, to.kind) = (distances, densities, kinds);
    }
}
