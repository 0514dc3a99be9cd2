//! Diffuse BSDFs: Lambert and Oren-Nayar.

mod block;

pub use block::OrenNayarBlock;

use std::f32::consts::{FRAC_1_PI, PI};

use super::{Bsdf, BsdfEval, BsdfKind, BsdfSample, Lobe};
use crate::math::{Rgb, Sample2D, Vec3, warp};

/// Lambert's law: the radiance is `albedo / pi` times the irradiance.
#[derive(Clone, Copy, Debug)]
pub struct Lambert {
    pub albedo: Rgb,
}

impl BsdfKind for Lambert {
    type Prepared = ();

    fn prepare(&self, _wo: Vec3) {}

    #[inline]
    fn eval_prepared(&self, (): &(), wo: Vec3, wi: Vec3) -> BsdfEval {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return BsdfEval::default();
        }
        BsdfEval {
            diffuse: self.albedo * (wi.z * FRAC_1_PI),
            glossy: Rgb::BLACK,
            pdf: warp::cosine_hemisphere_pdf(wi.z),
        }
    }

    #[inline]
    fn sample_prepared(&self, (): &(), wo: Vec3, _uc: f32, u: Sample2D) -> Option<BsdfSample> {
        let wi = u.cosine_hemisphere();
        (wo.z > 0.0 && wi.z > 0.0 && !self.albedo.is_black()).then_some(BsdfSample {
            wi,
            weight: self.albedo,
            diffuse: self.albedo,
            pdf: Some(warp::cosine_hemisphere_pdf(wi.z)),
            lobe: Lobe::Diffuse,
            eta: 1.0,
        })
    }

    fn has_lobes(&self) -> bool {
        false
    }

    fn mirrors(&self) -> bool {
        false
    }

    fn immersed(&self, _outside: f32) -> Option<Bsdf> {
        None
    }

    #[inline]
    fn lambert_albedo(&self) -> Option<Rgb> {
        Some(self.albedo)
    }
}

/// The energy-preserving Oren-Nayar model (EON): a rough diffuse surface, which looks flatter than
/// Lambert, as the moon does.
///
/// Multiple scattering between facets is included, so no energy is lost. Source: Portsmouth, Kutz,
/// Hill, "EON: A practical energy-preserving rough diffuse BRDF", JCGT 14(1), 2025; the albedo's
/// polynomial is theirs, off by less than 0.001. After Oren and Nayar, "Generalization of Lambert's
/// reflectance model", SIGGRAPH 1994, doi:10.1145/192161.192213.
#[derive(Clone, Copy, Debug)]
pub struct OrenNayar {
    pub albedo: Rgb,
    /// From 0 (Lambert) to 1.
    pub roughness: f32,
}

/// The part of the light that leaves facets of an albedo after several reflections; `mean` is the mean albedo of white facets.
#[inline(always)]
fn multiple(albedo: f32, mean: f32) -> f32 {
    albedo * albedo * mean / (1.0 - albedo * (1.0 - mean)).max(1e-7)
}

impl OrenNayar {
    /// `f |cos|` of two directions above the surface.
    #[inline(always)]
    fn f_cos(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let constant = self.constant();
        let s = wo.dot(wi) - wo.z * wi.z;
        let t = if s > 0.0 { wo.z.max(wi.z) } else { 1.0 };
        let single = constant * (1.0 + self.roughness * s / t);
        let mean = constant * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * self.roughness);
        let shape = self.lost(wo.z) * self.lost(wi.z) / (1.0 - mean).max(1e-7);
        let Rgb { r, g, b } = self.albedo;
        let multiple = Rgb::new(multiple(r, mean), multiple(g, mean), multiple(b, mean));
        (self.albedo * single + multiple * shape) * (wi.z * FRAC_1_PI)
    }

    /// The part of the light that does not leave white facets after one reflection.
    #[inline(always)]
    fn lost(&self, cos: f32) -> f32 {
        (1.0 - self.single_albedo(cos)).max(1e-7)
    }

    /// The weight of the constant part of the light that leaves after one facet.
    #[inline(always)]
    fn constant(&self) -> f32 {
        1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * self.roughness)
    }

    /// The albedo of white facets after one reflection.
    #[inline(always)]
    fn single_albedo(&self, cos: f32) -> f32 {
        let x = 1.0 - cos;
        let lit = x * (0.057_108_53 + x * (0.491_881_87 + x * (-0.332_181_44 + x * 0.071_442_99)));
        self.constant() * (1.0 + self.roughness * lit)
    }
}

impl BsdfKind for OrenNayar {
    type Prepared = ();

    fn prepare(&self, _wo: Vec3) {}

    fn eval_prepared(&self, (): &(), wo: Vec3, wi: Vec3) -> BsdfEval {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return BsdfEval::default();
        }
        BsdfEval {
            diffuse: self.f_cos(wo, wi),
            glossy: Rgb::BLACK,
            pdf: warp::cosine_hemisphere_pdf(wi.z),
        }
    }

    fn sample_prepared(&self, (): &(), wo: Vec3, _uc: f32, u: Sample2D) -> Option<BsdfSample> {
        let wi = u.cosine_hemisphere();
        let eval = self.eval_prepared(&(), wo, wi);
        (eval.pdf > 0.0 && !self.albedo.is_black()).then(|| BsdfSample {
            wi,
            weight: eval.diffuse / eval.pdf,
            diffuse: eval.diffuse / eval.pdf,
            pdf: Some(eval.pdf),
            lobe: Lobe::Diffuse,
            eta: 1.0,
        })
    }

    fn has_lobes(&self) -> bool {
        false
    }

    fn mirrors(&self) -> bool {
        false
    }

    fn immersed(&self, _outside: f32) -> Option<Bsdf> {
        None
    }
}
