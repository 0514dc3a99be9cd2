//! Light that leaves in all directions alike.

use std::f32::consts::FRAC_1_PI;

use super::{BsdfEval, BsdfKind, BsdfSample, Lobe};
use crate::math::{Rgb, Vec2, Vec3, warp};

/// Lambert's law: the radiance is `albedo / pi` times the irradiance.
#[derive(Clone, Copy, Debug)]
pub struct Lambert {
    pub albedo: Rgb,
}

impl BsdfKind for Lambert {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
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
    fn sample(&self, wo: Vec3, _uc: f32, u: Vec2) -> Option<BsdfSample> {
        let wi = warp::square_to_cosine_hemisphere(u);
        (wo.z > 0.0 && wi.z > 0.0 && !self.albedo.is_black()).then_some(BsdfSample {
            wi,
            weight: self.albedo,
            diffuse: self.albedo,
            pdf: Some(warp::cosine_hemisphere_pdf(wi.z)),
            lobe: Lobe::Diffuse,
            eta: 1.0,
        })
    }
}
