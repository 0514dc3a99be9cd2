//! The energy-conserving Phong BSDF: a diffuse lobe, a highlight about the mirror direction, a
//! mirror and a refracted ray.
//!
//! The highlight `specular (n + 2) / (2 pi) cos^n` reflects at most the part `specular` of the
//! light. Weights that together would reflect more than arrives are scaled down to what arrives.
//! Source: Lafortune and Willems, "Using the modified Phong reflectance model for physically based
//! rendering", report CW 197, KU Leuven, 1994.

use std::f32::consts::{FRAC_1_PI, TAU};

use super::{
    Bsdf, BsdfEval, BsdfKind, BsdfSample, Lobe,
    fresnel::{mirrored, refract},
};
use crate::math::{Frame, Rgb, Sample2D, Vec3, exponential, warp};

#[derive(Clone, Copy, Debug)]
pub struct Phong {
    diffuse: Rgb,
    specular: Rgb,
    reflect: Rgb,
    transmit: Rgb,
    shininess: f32,
    /// Index of refraction behind the surface over that in front.
    ior: f32,
}

/// The weights of the four lobes.
#[derive(Clone, Copy, Debug)]
pub struct PhongWeights {
    pub diffuse: Rgb,
    pub specular: Rgb,
    pub reflect: Rgb,
    pub transmit: Rgb,
}

/// The chances of the lobes: diffuse, specular, reflect and transmit.
type PhongProbabilities = [f32; 4];

impl Phong {
    /// `ior` is the index of refraction behind the surface over that in front.
    pub fn new(weights: PhongWeights, shininess: f32, ior: f32) -> Self {
        let all = weights.diffuse + weights.specular + weights.reflect + weights.transmit;
        let scale = 1.0 / all.max_component().max(1.0);
        Self {
            diffuse: weights.diffuse * scale,
            specular: weights.specular * scale,
            reflect: weights.reflect * scale,
            transmit: weights.transmit * scale,
            shininess,
            ior,
        }
    }

    /// The weights of reflection and transmission; under total reflection all is reflected.
    fn deltas(&self, o: Vec3, eta: f32) -> (Rgb, Option<(Vec3, Rgb)>) {
        if self.transmit.is_black() {
            return (self.reflect, None);
        }
        match refract(o, Vec3::Z, eta) {
            Some(wi) => (self.reflect, Some((wi, self.transmit))),
            None => (self.reflect + self.transmit, None),
        }
    }

    fn probabilities(&self, reflect: Rgb, transmit: Rgb) -> Option<PhongProbabilities> {
        let parts = [self.diffuse, self.specular, reflect, transmit].map(Rgb::max_component);
        let sum: f32 = parts.iter().sum();
        (sum > 0.0).then(|| parts.map(|p| p / sum))
    }

    fn eta(&self, wo: Vec3) -> f32 {
        if wo.z < 0.0 { 1.0 / self.ior } else { self.ior }
    }

    /// Evaluates the lobes that are not delta, with both directions above the surface.
    fn eval_upright(&self, o: Vec3, i: Vec3, probabilities: &PhongProbabilities) -> BsdfEval {
        if i.z <= 0.0 {
            return BsdfEval::default();
        }
        let cos = Vec3::new(-o.x, -o.y, o.z).dot(i);
        let power = if cos <= 0.0 || self.specular.is_black() {
            0.0
        } else {
            exponential::pow(cos, self.shininess)
        };
        BsdfEval {
            diffuse: self.diffuse * (i.z * FRAC_1_PI),
            glossy: self.specular * (power * (self.shininess + 2.0) / TAU * i.z),
            pdf: probabilities[0] * warp::cosine_hemisphere_pdf(i.z)
                + probabilities[1] * power * (self.shininess + 1.0) / TAU,
        }
    }
}

/// The side of `wo`, from which the surface looks the same.
fn upright(wo: Vec3, w: Vec3) -> Vec3 {
    if wo.z < 0.0 { mirrored(w) } else { w }
}

impl BsdfKind for Phong {
    type Prepared = ();

    fn prepare(&self, _wo: Vec3) {}

    fn eval_prepared(&self, (): &(), wo: Vec3, wi: Vec3) -> BsdfEval {
        let o = upright(wo, wo);
        let (reflect, transmitted) = self.deltas(o, self.eta(wo));
        let Some(probabilities) = self.probabilities(reflect, transmitted.map_or(Rgb::BLACK, |t| t.1)) else {
            return BsdfEval::default();
        };
        self.eval_upright(o, upright(wo, wi), &probabilities)
    }

    fn sample_prepared(&self, (): &(), wo: Vec3, uc: f32, u: Sample2D) -> Option<BsdfSample> {
        let (o, eta) = (upright(wo, wo), self.eta(wo));
        if o.z <= 0.0 {
            return None;
        }
        let (reflect, transmitted) = self.deltas(o, eta);
        let probabilities = self.probabilities(reflect, transmitted.map_or(Rgb::BLACK, |t| t.1))?;
        let mirror = Vec3::new(-o.x, -o.y, o.z);
        let delta = |i: Vec3, weight: Rgb, lobe: Lobe, eta: f32| BsdfSample {
            wi: upright(wo, i),
            weight,
            diffuse: Rgb::BLACK,
            pdf: None,
            lobe,
            eta,
        };
        let [diffuse, specular, mirror_probability, _] = probabilities;
        let (i, lobe) = if uc < diffuse {
            (u.cosine_hemisphere(), Lobe::Diffuse)
        } else if uc < diffuse + specular {
            let about = warp::square_to_power_cosine(u.square, self.shininess);
            (Frame::from_normal(mirror).to_world(about), Lobe::Specular)
        } else if let Some((i, weight)) = transmitted
            && uc >= diffuse + specular + mirror_probability
        {
            return Some(delta(i, weight / probabilities[3], Lobe::Transmission, eta));
        } else if mirror_probability > 0.0 {
            return Some(delta(mirror, reflect / mirror_probability, Lobe::Specular, 1.0));
        } else {
            return None;
        };
        let eval = self.eval_upright(o, i, &probabilities);
        (eval.pdf > 0.0).then(|| BsdfSample {
            wi: upright(wo, i),
            weight: eval.f_cos() / eval.pdf,
            diffuse: eval.diffuse / eval.pdf,
            pdf: Some(eval.pdf),
            lobe,
            eta: 1.0,
        })
    }

    fn transmits(&self) -> bool {
        !self.transmit.is_black()
    }

    fn is_delta(&self) -> bool {
        self.diffuse.is_black() && self.specular.is_black()
    }

    fn immersed(&self, _outside: f32) -> Option<Bsdf> {
        None
    }
}
