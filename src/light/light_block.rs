//! Blocks of light samples at many points.

use super::LightSample;
use crate::math::{
    Rgb, Vec3,
    block::{Each, LANES, get, set},
};

/// A light sample for each of several points.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct LightBlock {
    pub(super) wi: [Each; 3],
    pub(super) distance: Each,
    pub(super) pdf: Each,
    pub(super) li: Each<Rgb>,
    /// [`LightBlock::NONE`], [`LightBlock::AREA`] or [`LightBlock::DELTA`].
    pub(super) kind: Each<u32>,
}

impl LightBlock {
    /// The number of points.
    pub const LEN: usize = LANES;

    /// Kinds of samples: no light, light with a density, and light from a single direction.
    pub(super) const NONE: u32 = 0;
    pub(super) const AREA: u32 = 1;
    const DELTA: u32 = 2;

    pub const EMPTY: Self = Self {
        wi: [[0.0; LANES]; 3],
        distance: [0.0; LANES],
        pdf: [0.0; LANES],
        li: [Rgb::BLACK; LANES],
        kind: [Self::NONE; LANES],
    };

    /// Sets the light at a point.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, sample: Option<&LightSample>) {
        let lane = lane % LANES;
        let Some(sample) = sample else {
            self.kind[lane] = Self::NONE;
            return;
        };
        set(&mut self.wi, lane, sample.wi);
        self.distance[lane] = sample.distance;
        self.li[lane] = sample.li;
        self.pdf[lane] = sample.pdf.unwrap_or(1.0);
        self.kind[lane] = if sample.pdf.is_some() { Self::AREA } else { Self::DELTA };
    }

    /// Sets the radiance at a point where light arrives from an area; none arrives if it is black.
    #[inline(always)]
    pub fn set_radiance(&mut self, lane: usize, li: Rgb) {
        let lane = lane % LANES;
        self.li[lane] = li;
        if li.is_black() {
            self.kind[lane] = Self::NONE;
        }
    }

    /// The light at a point, if any arrives.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Option<LightSample> {
        let lane = lane % LANES;
        (self.kind[lane] != Self::NONE).then(|| LightSample {
            wi: self.wi(lane),
            distance: self.distance[lane],
            li: self.li[lane],
            pdf: (self.kind[lane] == Self::AREA).then_some(self.pdf[lane]),
        })
    }

    /// The unit direction towards the light.
    #[inline(always)]
    pub fn wi(&self, lane: usize) -> Vec3 {
        get(&self.wi, lane)
    }

    /// The distance to the light, in m.
    #[inline(always)]
    pub fn distance(&self, lane: usize) -> f32 {
        self.distance[lane]
    }

    /// The density of the direction in sr^-1; 1 for a single direction.
    #[inline(always)]
    pub fn pdf(&self, lane: usize) -> f32 {
        self.pdf[lane]
    }

    /// The light of [`LightSample::li`], if any arrives, and whether it comes from a single direction.
    #[inline(always)]
    pub fn li(&self, lane: usize) -> Option<(Rgb, bool)> {
        let lane = lane % LANES;
        let kind = self.kind[lane];
        (kind != Self::NONE).then_some((self.li[lane], kind == Self::DELTA))
    }
}
