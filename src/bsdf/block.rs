//! The contract of blocks of BSDFs of one kind, which are evaluated and sampled on vectors.

use super::{Bsdf, BsdfKind};
use crate::math::{
    Rgb, Sample2D, Vec3,
    block::{Each, LANES},
};

/// BSDFs of one kind, number by number. All give the bits of single ones (tested).
pub trait BsdfBlock {
    type Kind: BsdfKind;

    /// A block of no surfaces, whose results have no meaning.
    const EMPTY: Self;

    /// The BSDF as one of the kind.
    fn kind(bsdf: &Bsdf) -> Option<&Self::Kind>;

    /// Sets the BSDF of a lane, and returns whether a block can hold it.
    fn set(&mut self, lane: usize, bsdf: &Self::Kind) -> bool;

    /// Sets the unit direction to the viewer of a lane, above the surface, in its frame.
    fn set_view(&mut self, lane: usize, wo: Vec3);

    /// Finds what depends on the viewers; see [`BsdfKind::prepare`].
    fn prepare(&mut self);

    /// Evaluates the BSDFs, which are prepared, for a direction each.
    fn eval(&self, wi: &[Each; 3]) -> EvalBlock;

    /// Samples a direction of each BSDF, which is prepared, by numbers as those of [`BsdfKind::sample`].
    fn sample(&self, choices: &Each, samples: &Each<Sample2D>) -> SampleBlock;
}

/// The values of BSDFs for a direction each, as [`BsdfEval`](super::BsdfEval) has them.
#[derive(Clone, Debug)]
pub struct EvalBlock {
    pub diffuse: [Each; 3],
    pub glossy: [Each; 3],
    pub pdf: Each,
}

impl EvalBlock {
    pub const EMPTY: Self = Self {
        diffuse: [[0.0; LANES]; 3],
        glossy: [[0.0; LANES]; 3],
        pdf: [0.0; LANES],
    };
}

/// `c` where it `is` there, else black.
#[inline(always)]
pub(super) fn or_black(is: bool, c: Rgb) -> Rgb {
    Rgb::new(
        if is { c.r } else { 0.0 },
        if is { c.g } else { 0.0 },
        if is { c.b } else { 0.0 },
    )
}

/// Directions that BSDFs sampled, as [`BsdfSample`](super::BsdfSample) has them; the densities are 0 where light is absorbed.
#[derive(Clone, Debug)]
pub struct SampleBlock {
    pub wi: [Each; 3],
    pub weight: [Each; 3],
    pub diffuse: [Each; 3],
    pub pdf: Each,
    /// Not 0 where the lobe is diffuse; it is specular elsewhere.
    pub is_diffuse: Each<u32>,
}

impl SampleBlock {
    pub const EMPTY: Self = Self {
        wi: [[0.0; LANES]; 3],
        weight: [[0.0; LANES]; 3],
        diffuse: [[0.0; LANES]; 3],
        pdf: [0.0; LANES],
        is_diffuse: [0; LANES],
    };
}
