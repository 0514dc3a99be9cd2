//! Conductors, smooth and rough.

mod block;

pub use block::ConductorBlock;

use super::{
    Bsdf, BsdfEval, BsdfKind, BsdfSample, Lobe,
    albedo::MirrorFacets,
    fresnel::{self, schlick_term},
    microfacet::Ggx,
};
use crate::math::{Rgb, Sample2D, Vec3};

/// The reflectance of a metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reflectance {
    /// The complex index of refraction `eta + i k`.
    Measured { eta: Rgb, k: Rgb },
    /// The reflectance at normal incidence, and the dip at about 82 degrees.
    Colored { f0: Rgb, dip: Rgb },
}

/// The cosine where the dip of a coloured metal is deepest, at 82 degrees.
const DIP_COS: f32 = 1.0 / 7.0;

/// Schlick's approximation there.
fn schlick_at_dip(f0: Rgb) -> Rgb {
    f0 + (Rgb::WHITE - f0) * schlick_term(DIP_COS)
}

/// The weight of the dip there.
fn dip_depth() -> f32 {
    DIP_COS * schlick_term(DIP_COS) * (1.0 - DIP_COS)
}

/// The reflectance of a coloured metal at the cosine `cos`.
#[inline(always)]
fn colored_reflectance(f0: Rgb, dip: Rgb, cos: f32) -> Rgb {
    let grazing = schlick_term(cos);
    let reflected = f0 + (Rgb::WHITE - f0) * grazing - dip * (cos * grazing * (1.0 - cos));
    Rgb::new(
        reflected.r.clamp(0.0, 1.0),
        reflected.g.clamp(0.0, 1.0),
        reflected.b.clamp(0.0, 1.0),
    )
}

impl Reflectance {
    /// A metal of the colour `f0` whose reflectance at 82 degrees is `edge` times the one that
    /// Schlick's approximation gives.
    ///
    /// Source: Kutz, Hasan, Edmondson, "Novel aspects of the Adobe Standard Material", 2021,
    /// section 2 ("F82").
    pub fn colored(f0: Rgb, edge: Rgb) -> Self {
        Self::Colored {
            f0,
            dip: schlick_at_dip(f0) * (Rgb::WHITE - edge) / dip_depth(),
        }
    }

    /// The metal whose reflectances at normal incidence and at 82 degrees are those of this one, converted.
    pub fn converted(&self, convert: impl Fn(Rgb) -> Rgb) -> Self {
        let (f0, at_dip) = (convert(self.at(1.0)), convert(self.at(DIP_COS)));
        Self::Colored {
            f0,
            dip: (schlick_at_dip(f0) - at_dip) / dip_depth(),
        }
    }

    /// At the cosine `cos`.
    #[inline]
    pub fn at(&self, cos: f32) -> Rgb {
        match self {
            Self::Measured { eta, k } => Rgb::new(
                fresnel::conductor(cos, eta.r, k.r),
                fresnel::conductor(cos, eta.g, k.g),
                fresnel::conductor(cos, eta.b, k.b),
            ),
            Self::Colored { f0, dip } => colored_reflectance(*f0, *dip, cos),
        }
    }

    /// At normal incidence.
    pub fn normal(&self) -> Rgb {
        match self {
            Self::Measured { .. } => self.at(1.0),
            Self::Colored { f0, .. } => *f0,
        }
    }
}

/// A rough conductor, by the distribution of its facets. Multiple scattering between facets is tinted by the reflectance at normal
/// incidence.
#[derive(Clone, Copy, Debug)]
pub struct Conductor<F: MirrorFacets = Ggx> {
    facets: F,
    reflectance: Reflectance,
    /// Multiplies the reflectance of measured metals.
    tint: Rgb,
    /// The tinted reflectance at normal incidence, and the albedo of white facets.
    normal: Rgb,
    albedo: F::Albedo,
}

impl<F: MirrorFacets> Conductor<F> {
    pub fn new(facets: F, reflectance: Reflectance) -> Self {
        Self::tinted(facets, reflectance, Rgb::WHITE)
    }

    /// One whose reflectance is multiplied by `tint`, which is white for coloured metals.
    pub fn tinted(facets: F, reflectance: Reflectance, tint: Rgb) -> Self {
        Self {
            facets,
            reflectance,
            tint,
            normal: reflectance.normal() * tint,
            albedo: facets.albedo(),
        }
    }
}

/// The gain of multiple scattering between facets of the reflectance `f0`, where white facets have
/// the albedo `all`.
#[inline(always)]
pub(super) fn multiscatter_gain(f0: Rgb, all: f32) -> Rgb {
    Rgb::WHITE + f0 * ((1.0 - all) / all)
}

impl<F: MirrorFacets> BsdfKind for Conductor<F> {
    /// The gain of multiple scattering, tinted.
    type Prepared = Rgb;

    #[inline]
    fn prepare(&self, wo: Vec3) -> Rgb {
        multiscatter_gain(self.normal, self.facets.mirrors(&self.albedo, wo)) * self.tint
    }

    fn eval_prepared(&self, gain: &Rgb, wo: Vec3, wi: Vec3) -> BsdfEval {
        if self.facets.is_smooth() {
            return BsdfEval::default();
        }
        let Some(facet) = self.facets.reflection(wo, wi) else {
            return BsdfEval::default();
        };
        BsdfEval {
            diffuse: Rgb::BLACK,
            glossy: self.reflectance.at(facet.cos) * *gain * (facet.pdf * facet.masking),
            pdf: facet.pdf,
        }
    }

    fn sample_prepared(&self, gain: &Rgb, wo: Vec3, _uc: f32, u: Sample2D) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let (wi, weight, pdf) = if self.facets.is_smooth() {
            (
                Vec3::new(-wo.x, -wo.y, wo.z),
                self.reflectance.at(wo.z) * self.tint,
                None,
            )
        } else {
            let wi = self.facets.sample_reflection(wo, u.square)?;
            let facet = self.facets.reflection(wo, wi)?;
            (
                wi,
                self.reflectance.at(facet.cos) * *gain * facet.masking,
                Some(facet.pdf),
            )
        };
        (!weight.is_black()).then_some(BsdfSample {
            wi,
            weight,
            diffuse: Rgb::BLACK,
            pdf,
            lobe: Lobe::Specular,
            eta: 1.0,
        })
    }

    fn reads_tangent(&self) -> bool {
        !self.facets.is_isotropic()
    }

    fn is_delta(&self) -> bool {
        self.facets.is_smooth()
    }

    fn has_lobes(&self) -> bool {
        false
    }

    fn immersed(&self, _outside: f32) -> Option<Bsdf> {
        None
    }
}
