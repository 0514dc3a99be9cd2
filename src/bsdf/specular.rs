//! Perfectly smooth surfaces: delta reflection and refraction.

use super::{
    Bsdf, BsdfEval, BsdfKind, BsdfSample, Lobe,
    fresnel::{dielectric, is_total, reflect, refract},
    is_equal_ior,
};
use crate::math::{Rgb, Sample2D, Vec3};

/// A perfect mirror.
#[derive(Clone, Copy, Debug)]
pub struct Mirror {
    pub reflectance: Rgb,
}

impl BsdfKind for Mirror {
    type Prepared = ();

    fn prepare(&self, _wo: Vec3) {}

    fn eval_prepared(&self, (): &(), _wo: Vec3, _wi: Vec3) -> BsdfEval {
        BsdfEval::default()
    }

    fn sample_prepared(&self, (): &(), wo: Vec3, _uc: f32, _u: Sample2D) -> Option<BsdfSample> {
        (wo.z > 0.0 && !self.reflectance.is_black()).then_some(BsdfSample {
            wi: Vec3::new(-wo.x, -wo.y, wo.z),
            weight: self.reflectance,
            diffuse: Rgb::BLACK,
            pdf: None,
            lobe: Lobe::Specular,
            eta: 1.0,
        })
    }

    fn is_delta(&self) -> bool {
        true
    }

    fn has_lobes(&self) -> bool {
        false
    }

    fn immersed(&self, _outside: f32) -> Option<Bsdf> {
        None
    }
}

/// A smooth dielectric boundary, which reflects and refracts by Fresnel's equations.
#[derive(Clone, Copy, Debug)]
pub struct SmoothDielectric {
    /// Index of refraction behind the surface over that in front.
    pub ior: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

impl SmoothDielectric {
    /// A boundary between media whose indices of refraction have the ratio `ior`.
    pub fn new(ior: f32, reflectance: Rgb, transmittance: Rgb) -> Self {
        Self {
            ior: if is_equal_ior(ior, 1.0) { 1.0 } else { ior },
            reflectance,
            transmittance,
        }
    }
}

impl BsdfKind for SmoothDielectric {
    type Prepared = ();

    fn prepare(&self, _wo: Vec3) {}

    fn eval_prepared(&self, (): &(), _wo: Vec3, _wi: Vec3) -> BsdfEval {
        BsdfEval::default()
    }

    fn sample_prepared(&self, (): &(), wo: Vec3, uc: f32, _u: Sample2D) -> Option<BsdfSample> {
        let (n, eta) = if wo.z < 0.0 {
            (-Vec3::Z, 1.0 / self.ior)
        } else {
            (Vec3::Z, self.ior)
        };
        let reflected = dielectric(n.dot(wo), eta);
        let (by_reflection, by_transmission) = (
            reflected * self.reflectance.max_component(),
            (1.0 - reflected) * self.transmittance.max_component(),
        );
        let all = by_reflection + by_transmission;
        if all <= 0.0 {
            return None;
        }
        let (wi, weight, lobe, eta) = if uc * all < by_reflection {
            let weight = self.reflectance * (reflected * all / by_reflection);
            (reflect(wo, n), weight, Lobe::Specular, 1.0)
        } else {
            let weight = self.transmittance * ((1.0 - reflected) * all / by_transmission);
            (refract(wo, n, eta)?, weight, Lobe::Transmission, eta)
        };
        Some(BsdfSample {
            wi,
            weight,
            diffuse: Rgb::BLACK,
            pdf: None,
            lobe,
            eta,
        })
    }

    fn transmits(&self) -> bool {
        true
    }

    fn reflects_totally(&self, wo_z: f32) -> bool {
        is_total(wo_z, self.ior)
    }

    fn straight(&self, wo: Vec3) -> Rgb {
        if self.ior == 1.0 {
            self.transmittance * (1.0 - dielectric(wo.z.abs(), 1.0))
        } else {
            Rgb::BLACK
        }
    }

    fn is_delta(&self) -> bool {
        true
    }

    fn immersed(&self, outside: f32) -> Option<Bsdf> {
        let immersed = Self::new(self.ior / outside, self.reflectance, self.transmittance);
        Some(Bsdf::SmoothDielectric(immersed))
    }
}
