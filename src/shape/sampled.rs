//! Kinds of emitters whose points are sampled in blocks.

use super::ShapeSample;
use crate::math::{Vec2, Vec3, float::gamma};

/// A kind of emitter whose points are sampled in blocks.
pub(super) trait SampledKind<const N: usize>: Sized {
    /// Returns what [`SampledKind::sample_by`] reads of an emitter.
    fn sample_numbers(&self) -> [f64; N];

    /// Samples the emitter with these numbers as seen from `from`: the same operations for all, without branches.
    fn sample_by(numbers: &[f64; N], from: Vec3, u: Vec2) -> SampledPoint;

    /// Samples one emitter whose points are always known.
    #[inline(always)]
    fn sample_one(&self, from: Vec3, u: Vec2) -> Option<ShapeSample> {
        let SampledPoint { p, ng, pdf, .. } = Self::sample_by(&self.sample_numbers(), from, u);
        (pdf > 0.0).then_some(ShapeSample { p, ng, pdf })
    }
}

/// A sampled point of an emitter.
#[derive(Clone, Copy, Debug)]
pub struct SampledPoint {
    pub p: Vec3,
    /// Bound on the absolute error of each coordinate of `p`.
    pub p_error: Vec3,
    /// Unit, as authored.
    pub ng: Vec3,
    /// The density of the direction in sr^-1; not above 0 where there is no sample.
    pub pdf: f32,
    /// Whether the block drew this sample; otherwise the emitter is sampled by itself.
    pub is_known: bool,
}

impl SampledPoint {
    /// The known point `p` of a surface in double precision.
    #[inline(always)]
    pub(super) fn new(p: Vec3, ng: Vec3, pdf: f32) -> Self {
        Self {
            p,
            p_error: p.abs() * gamma(4),
            ng,
            pdf,
            is_known: true,
        }
    }
}
