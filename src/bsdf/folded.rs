//! A BSDF under a normal map: directions below the surface are mirrored to above it.
//!
//! A facet that a normal map tilts sees a part of the surface that it lies on. That part is taken for a mirror, so that the
//! facet loses no light. Source: Schuessler, Heitz, Hanika, Dachsbacher, "Microfacet-based Normal Mapping for Robust Monte
//! Carlo Path Tracing", ACM TOG 36(6), 2017, doi:10.1145/3130800.3130806, whose tangent facets are mirrors here; the masking
//! between facets is left out, and so is light that meets the mirror before the facet.

use super::{
    Bsdf, BsdfEval, BsdfKind, BsdfSample,
    block::{EvalBlock, SampleBlock, or_black},
};
use crate::math::{
    Sample2D, Vec3,
    block::{Each, LANES, get, get_rgb, set, set_rgb},
    float::select,
};

/// An opaque BSDF whose normal is not that of the surface.
pub struct Folded<'a, B> {
    pub bsdf: &'a B,
    /// The unit normal of the surface on the side of the viewer, in the shading frame.
    pub plane: Vec3,
}

/// The mirror image of `w` in the plane of this unit normal.
#[inline(always)]
fn mirrored(plane: Vec3, w: Vec3) -> Vec3 {
    w - plane * (2.0 * plane.dot(w))
}

impl<B: BsdfKind> BsdfKind for Folded<'_, B> {
    type Prepared = B::Prepared;

    fn prepare(&self, wo: Vec3) -> B::Prepared {
        self.bsdf.prepare(wo)
    }

    fn eval_prepared(&self, prepared: &B::Prepared, wo: Vec3, wi: Vec3) -> BsdfEval {
        if self.plane.dot(wi) <= 0.0 {
            return BsdfEval::default();
        }
        let above = self.bsdf.eval_prepared(prepared, wo, wi);
        let below = self.bsdf.eval_prepared(prepared, wo, mirrored(self.plane, wi));
        BsdfEval {
            diffuse: above.diffuse + below.diffuse,
            glossy: above.glossy + below.glossy,
            pdf: above.pdf + below.pdf,
        }
    }

    fn sample_prepared(&self, prepared: &B::Prepared, wo: Vec3, uc: f32, u: Sample2D) -> Option<BsdfSample> {
        let mut sample = self.bsdf.sample_prepared(prepared, wo, uc, u)?;
        let image = mirrored(self.plane, sample.wi);
        if let Some(pdf) = &mut sample.pdf {
            *pdf += self.bsdf.eval_prepared(prepared, wo, image).pdf;
        }
        if self.plane.dot(sample.wi) < 0.0 {
            sample.wi = image;
        }
        Some(sample)
    }

    fn reads_tangent(&self) -> bool {
        self.bsdf.reads_tangent()
    }

    fn has_lobes(&self) -> bool {
        self.bsdf.has_lobes()
    }

    fn mirrors(&self) -> bool {
        self.bsdf.mirrors()
    }

    fn is_delta(&self) -> bool {
        self.bsdf.is_delta()
    }

    fn immersed(&self, outside: f32) -> Option<Bsdf> {
        self.bsdf.immersed(outside)
    }
}

/// The planes of [`Folded`] for the BSDFs of a block, those that have one. Its methods are not inlined,
/// for the sake of the program's size.
#[derive(Clone, Debug)]
pub struct FoldBlock {
    plane: [Each; 3],
    /// Not 0 where the BSDF is folded.
    is_folded: Each<u32>,
}

impl FoldBlock {
    pub const EMPTY: Self = Self {
        plane: [[0.0; LANES]; 3],
        is_folded: [0; LANES],
    };

    /// Sets the plane of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, plane: Option<Vec3>) {
        set(&mut self.plane, lane, plane.unwrap_or(Vec3::ZERO));
        self.is_folded[lane] = u32::from(plane.is_some());
    }

    #[inline(always)]
    pub fn is_folded(&self, lane: usize) -> bool {
        self.is_folded[lane] != 0
    }

    /// Whether any BSDF is folded.
    #[inline(always)]
    pub fn is_any(&self) -> bool {
        self.is_folded != [0; LANES]
    }

    /// The mirror images of directions.
    #[inline(never)]
    pub fn mirrored(&self, w: &[Each; 3]) -> [Each; 3] {
        let mut images = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            set(&mut images, lane, mirrored(get(&self.plane, lane), get(w, lane)));
        }
        images
    }

    /// Makes the values of folded BSDFs for the directions `wi` from those of the BSDFs, to which it adds those for the `images`.
    #[inline(never)]
    pub fn add(&self, to: &mut EvalBlock, wi: &[Each; 3], images: &EvalBlock) {
        let mut sum = EvalBlock::EMPTY;
        for lane in 0..LANES {
            let is_folded = self.is_folded(lane);
            let is_above = !is_folded | (get(&self.plane, lane).dot(get(wi, lane)) > 0.0);
            let diffuse = get_rgb(&to.diffuse, lane) + or_black(is_folded, get_rgb(&images.diffuse, lane));
            let glossy = get_rgb(&to.glossy, lane) + or_black(is_folded, get_rgb(&images.glossy, lane));
            let pdf = to.pdf[lane] + if is_folded { images.pdf[lane] } else { 0.0 };
            set_rgb(&mut sum.diffuse, lane, or_black(is_above, diffuse));
            set_rgb(&mut sum.glossy, lane, or_black(is_above, glossy));
            sum.pdf[lane] = if is_above { pdf } else { 0.0 };
        }
        *to = sum;
    }

    /// Makes the samples of folded BSDFs from those of the BSDFs, whose directions have these `images` with these densities.
    #[inline(never)]
    pub fn fold(&self, samples: &mut SampleBlock, images: &[Each; 3], pdfs: &Each) {
        let (mut wi, mut pdf) = (samples.wi, samples.pdf);
        for lane in 0..LANES {
            let is_below = get(&self.plane, lane).dot(get(&samples.wi, lane)) < 0.0;
            let own = samples.pdf[lane];
            set(
                &mut wi,
                lane,
                select(is_below, get(images, lane), get(&samples.wi, lane)),
            );
            pdf[lane] = if self.is_folded(lane) & (own > 0.0) {
                own + pdfs[lane]
            } else {
                own
            };
        }
        (samples.wi, samples.pdf) = (wi, pdf);
    }
}
