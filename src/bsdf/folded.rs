//! A BSDF under a normal map: directions below the surface are mirrored to above it.
//!
//! A facet that a normal map tilts sees a part of the surface that it lies on. That part is taken for a mirror, so that the
//! facet loses no light. Source: Schuessler, Heitz, Hanika, Dachsbacher, "Microfacet-based Normal Mapping for Robust Monte
//! Carlo Path Tracing", ACM TOG 36(6), 2017, doi:10.1145/3130800.3130806, whose tangent facets are mirrors here; the masking
//! between facets is left out, and so is light that meets the mirror before the facet.

use super::{Bsdf, BsdfEval, BsdfKind, BsdfSample};
use crate::math::{Sample2D, Vec3};

/// An opaque BSDF whose normal is not that of the surface.
pub struct Folded<'a, B> {
    pub bsdf: &'a B,
    /// The unit normal of the surface on the side of the viewer, in the shading frame.
    pub plane: Vec3,
}

impl<B> Folded<'_, B> {
    /// The mirror image of `w` in the surface.
    fn mirrored(&self, w: Vec3) -> Vec3 {
        w - self.plane * (2.0 * self.plane.dot(w))
    }
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
        let below = self.bsdf.eval_prepared(prepared, wo, self.mirrored(wi));
        BsdfEval {
            diffuse: above.diffuse + below.diffuse,
            glossy: above.glossy + below.glossy,
            pdf: above.pdf + below.pdf,
        }
    }

    fn sample_prepared(&self, prepared: &B::Prepared, wo: Vec3, uc: f32, u: Sample2D) -> Option<BsdfSample> {
        let mut sample = self.bsdf.sample_prepared(prepared, wo, uc, u)?;
        let image = self.mirrored(sample.wi);
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
