//! Rough dielectric boundaries, and thin dielectric panes without refraction.
//!
//! Transmitted radiance is not scaled by the square of the index of refraction: an object behind a clear surface looks as bright as
//! without it.

use super::{
    Bsdf, BsdfEval, BsdfKind, BsdfSample, Lobe,
    albedo::{self, ClearFacets, MirrorFacets},
    beckmann::Beckmann,
    fresnel::{dielectric, is_total, mirrored},
    is_equal_ior,
    microfacet::{Facet, Ggx},
    specular::SmoothDielectric,
};
use crate::math::{Rgb, Sample2D, Vec3};

/// A rough dielectric boundary, whose facets reflect and refract by Fresnel's equations.
#[derive(Clone, Copy, Debug)]
pub struct RoughDielectric<F: ClearFacets = Ggx> {
    /// Even.
    pub facets: F,
    /// Index of refraction behind the surface over that in front.
    pub ior: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

/// Facets whose boundaries are a kind of BSDF.
pub trait BoundaryFacets: ClearFacets {
    /// The BSDF of a rough boundary of these facets.
    fn bsdf(rough: RoughDielectric<Self>) -> Bsdf;
}

impl BoundaryFacets for Ggx {
    fn bsdf(rough: RoughDielectric<Self>) -> Bsdf {
        Bsdf::RoughDielectric(rough)
    }
}

impl BoundaryFacets for Beckmann {
    fn bsdf(rough: RoughDielectric<Self>) -> Bsdf {
        Bsdf::BeckmannDielectric(rough)
    }
}

impl<F: BoundaryFacets> From<RoughDielectric<F>> for Bsdf {
    /// Facets that are smooth, or lie between equal media, are those of a smooth boundary.
    fn from(rough: RoughDielectric<F>) -> Self {
        if rough.facets.is_smooth() || is_equal_ior(rough.ior, 1.0) {
            Self::SmoothDielectric(SmoothDielectric::new(rough.ior, rough.reflectance, rough.transmittance))
        } else {
            F::bsdf(rough)
        }
    }
}

/// The weights of reflection and transmission at a facet.
#[derive(Clone, Copy)]
struct FacetWeights {
    reflect: Rgb,
    transmit: Rgb,
    /// The probability of reflection.
    probability: f32,
}

/// Returns the weights of a facet of the reflectance `reflected`.
fn facet_weights(reflected: f32, reflectance: Rgb, transmittance: Rgb) -> Option<FacetWeights> {
    let (reflect, transmit) = (reflectance * reflected, transmittance * (1.0 - reflected));
    let all = reflect.max_component() + transmit.max_component();
    (all > 0.0).then_some(FacetWeights {
        reflect,
        transmit,
        probability: reflect.max_component() / all,
    })
}

impl<F: ClearFacets> RoughDielectric<F> {
    /// `wo` and `wi` as seen from the side of `wo`, and the index on the other side over that on
    /// this one.
    fn upright(&self, wo: Vec3, wi: Vec3) -> (Vec3, Vec3, f32) {
        if wo.z < 0.0 {
            (mirrored(wo), mirrored(wi), 1.0 / self.ior)
        } else {
            (wo, wi, self.ior)
        }
    }

    fn facet_weights(&self, cos: f32, eta: f32) -> Option<FacetWeights> {
        facet_weights(dielectric(cos, eta), self.reflectance, self.transmittance)
    }
}

/// Evaluates the scattering of a facet from its weight and its probability.
fn eval_facet(facet: Facet, weight: Rgb, probability: f32) -> BsdfEval {
    BsdfEval {
        diffuse: Rgb::BLACK,
        glossy: weight * (facet.pdf * facet.masking),
        pdf: facet.pdf * probability,
    }
}

impl<F: BoundaryFacets> BsdfKind for RoughDielectric<F> {
    /// The gain of multiple scattering.
    type Prepared = f32;

    fn prepare(&self, wo: Vec3) -> f32 {
        let (o, _, eta) = self.upright(wo, wo);
        1.0 / albedo::clear(&self.facets, o, eta).fresnel
    }

    fn eval_prepared(&self, gain: &f32, wo: Vec3, wi: Vec3) -> BsdfEval {
        let (o, i, eta) = self.upright(wo, wi);
        let facet = if i.z > 0.0 {
            self.facets.reflection(o, i)
        } else {
            self.facets.transmission(o, i, eta)
        };
        let Some((facet, facet_weights)) = facet.and_then(|f| Some((f, self.facet_weights(f.cos, eta)?))) else {
            return BsdfEval::default();
        };
        if i.z > 0.0 {
            eval_facet(facet, facet_weights.reflect * *gain, facet_weights.probability)
        } else {
            eval_facet(facet, facet_weights.transmit * *gain, 1.0 - facet_weights.probability)
        }
    }

    fn sample_prepared(&self, gain: &f32, wo: Vec3, uc: f32, u: Sample2D) -> Option<BsdfSample> {
        let (o, _, eta) = self.upright(wo, wo);
        if o.z <= 0.0 {
            return None;
        }
        let h = self.facets.sample_normal(o, u.square);
        let facet_weights = self.facet_weights(o.dot(h), eta)?;
        let reflects = uc < facet_weights.probability;
        let i = if reflects {
            self.facets.sample_reflection(o, u.square)?
        } else {
            self.facets.sample_transmission(o, u.square, eta)?
        };
        let wi = if wo.z < 0.0 { mirrored(i) } else { i };
        let eval = self.eval_prepared(gain, wo, wi);
        (eval.pdf > 0.0).then_some(BsdfSample {
            wi,
            weight: eval.glossy / eval.pdf,
            diffuse: Rgb::BLACK,
            pdf: Some(eval.pdf),
            lobe: if reflects { Lobe::Specular } else { Lobe::Transmission },
            eta: if reflects { 1.0 } else { eta },
        })
    }

    fn reflects_totally(&self, wo_z: f32) -> bool {
        is_total(wo_z, self.ior)
    }

    fn transmits(&self) -> bool {
        true
    }

    fn immersed(&self, outside: f32) -> Option<Bsdf> {
        let ior = self.ior / outside;
        Some(Self { ior, ..*self }.into())
    }
}

/// A thin dielectric pane: two parallel boundaries, which transmit light without refraction; rough
/// ones scatter it.
///
/// Reflections between the boundaries are included; only the tints absorb light.
#[derive(Clone, Copy, Debug)]
pub struct ThinDielectric<F: MirrorFacets = Ggx> {
    pub facets: F,
    pub ior: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

/// The reflectance of two parallel boundaries, each of the reflectance `once`.
#[inline]
pub fn double_boundary(once: f32) -> f32 {
    2.0 * once / (1.0 + once)
}

impl<F: MirrorFacets> ThinDielectric<F> {
    fn facet_weights(&self, cos: f32) -> Option<FacetWeights> {
        let reflected = double_boundary(dielectric(cos, self.ior));
        facet_weights(reflected, self.reflectance, self.transmittance)
    }

    /// Zero where smooth. What passes is scattered like the mirror image, on the other side.
    fn eval_upright(&self, gain: f32, o: Vec3, i: Vec3) -> BsdfEval {
        let above = Vec3::new(i.x, i.y, i.z.abs());
        let facet = self.facets.reflection(o, above);
        let Some((facet, facet_weights)) = facet.and_then(|f| Some((f, self.facet_weights(f.cos)?))) else {
            return BsdfEval::default();
        };
        if i.z > 0.0 {
            eval_facet(facet, facet_weights.reflect * gain, facet_weights.probability)
        } else {
            eval_facet(facet, facet_weights.transmit * gain, 1.0 - facet_weights.probability)
        }
    }
}

impl<F: MirrorFacets> BsdfKind for ThinDielectric<F> {
    /// The gain of multiple scattering.
    type Prepared = f32;

    fn prepare(&self, wo: Vec3) -> f32 {
        let o = if wo.z < 0.0 { mirrored(wo) } else { wo };
        1.0 / self.facets.mirrors(&self.facets.albedo(), o)
    }

    fn eval_prepared(&self, gain: &f32, wo: Vec3, wi: Vec3) -> BsdfEval {
        if self.facets.is_smooth() {
            BsdfEval::default()
        } else if wo.z < 0.0 {
            self.eval_upright(*gain, mirrored(wo), mirrored(wi))
        } else {
            self.eval_upright(*gain, wo, wi)
        }
    }

    fn sample_prepared(&self, gain: &f32, wo: Vec3, uc: f32, u: Sample2D) -> Option<BsdfSample> {
        let below = wo.z < 0.0;
        let o = if below { mirrored(wo) } else { wo };
        if o.z <= 0.0 {
            return None;
        }
        let smooth = self.facets.is_smooth();
        let h = if smooth {
            Vec3::Z
        } else {
            self.facets.sample_normal(o, u.square)
        };
        let facet_weights = self.facet_weights(o.dot(h))?;
        let reflects = uc < facet_weights.probability;
        let above = if smooth {
            Vec3::new(-o.x, -o.y, o.z)
        } else {
            self.facets.sample_reflection(o, u.square)?
        };
        let i = if reflects { above } else { mirrored(above) };
        let (weight, pdf) = if smooth {
            let (weight, probability) = if reflects {
                (facet_weights.reflect, facet_weights.probability)
            } else {
                (facet_weights.transmit, 1.0 - facet_weights.probability)
            };
            (weight / probability, None)
        } else {
            let eval = self.eval_upright(*gain, o, i);
            if eval.pdf <= 0.0 {
                return None;
            }
            (eval.glossy / eval.pdf, Some(eval.pdf))
        };
        Some(BsdfSample {
            wi: if below { mirrored(i) } else { i },
            weight,
            diffuse: Rgb::BLACK,
            pdf,
            lobe: if reflects { Lobe::Specular } else { Lobe::Transmission },
            eta: 1.0,
        })
    }

    fn transmits(&self) -> bool {
        true
    }

    fn straight(&self, wo: Vec3) -> Rgb {
        if self.facets.is_smooth() {
            self.facet_weights(wo.z.abs()).map_or(Rgb::BLACK, |w| w.transmit)
        } else {
            Rgb::BLACK
        }
    }

    fn reads_tangent(&self) -> bool {
        !self.facets.is_isotropic()
    }

    fn is_delta(&self) -> bool {
        self.facets.is_smooth()
    }

    fn immersed(&self, _outside: f32) -> Option<Bsdf> {
        None
    }
}
