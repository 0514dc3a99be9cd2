//! Light from many lamps at once, each at a point of its own: the same as that of [`AreaSample`].

use super::{LightSample, area::AreaSample};
use crate::{
    math::{Dispatch, Rgb, Sidedness, Vec3, VectorLoop},
    shape::{
        RectangleBlock,
        block::{Each, LANES},
    },
};

/// Rectangular lamps, the points that they light, and their light.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct AreaBlock {
    pub rectangles: RectangleBlock,
    emission: [(Rgb, Sidedness); LANES],
    wi: [Each; 3],
    distance: Each,
    pdf: Each,
    front_cos: Each,
}

impl Default for AreaBlock {
    fn default() -> Self {
        Self {
            rectangles: RectangleBlock::EMPTY,
            emission: [(Rgb::BLACK, Sidedness::Front); LANES],
            wi: [[0.0; LANES]; 3],
            distance: [0.0; LANES],
            pdf: [0.0; LANES],
            front_cos: [0.0; LANES],
        }
    }
}

impl AreaBlock {
    /// Sets the emission of the lamp of a lane: its radiance in W m^-2 sr^-1, and the sides that shine.
    #[inline(always)]
    pub fn set_emission(&mut self, lane: usize, radiance: Rgb, sidedness: Sidedness) {
        self.emission[lane] = (radiance, sidedness);
    }

    /// Samples the lamps of all lanes.
    #[inline]
    pub fn sample(&mut self, on: impl Dispatch) {
        self.rectangles.sample(on);
        on.dispatch(Arrivals(self));
    }

    /// Returns the light of a lane's lamp, if any arrives.
    #[inline(always)]
    pub fn light(&self, lane: usize) -> Option<LightSample> {
        let (li, sidedness) = self.emission[lane];
        let (pdf, distance) = (self.pdf[lane], self.distance[lane]);
        let shines = self.front_cos[lane] > 0.0 || sidedness == Sidedness::Both;
        (shines && pdf > 0.0 && pdf.is_finite() && distance > 0.0).then(|| LightSample {
            wi: Vec3::new(self.wi[0][lane], self.wi[1][lane], self.wi[2][lane]),
            distance,
            li,
            pdf: Some(pdf),
        })
    }
}

/// Finds the directions and distances to the points of the lamps.
struct Arrivals<'a>(&'a mut AreaBlock);

impl VectorLoop for Arrivals<'_> {
    #[inline(always)]
    fn run(self) {
        let block = self.0;
        for i in 0..LANES {
            let from = block.rectangles.from(i);
            let (p, ng, pdf) = block.rectangles.point(i);
            let sample = AreaSample::in_world(p, ng, pdf);
            let (wi, distance) = sample.direction(from);
            (block.wi[0][i], block.wi[1][i], block.wi[2][i]) = (wi.x, wi.y, wi.z);
            (block.distance[i], block.pdf[i]) = (distance, pdf);
            block.front_cos[i] = sample.front_cos(from);
        }
    }
}
