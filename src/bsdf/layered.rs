//! The layered BSDF of the principled material: sheen over a clear coat over a blend of metal, a
//! transmitting dielectric, and a dielectric over a diffuse base, which may pass light on to the other
//! side.
//!
//! Each layer reflects a part of the light and passes the rest to the layers below, so white layers
//! neither lose nor gain energy. The parts are the albedos of the layers towards the viewer, so the
//! BSDF is not exactly reciprocal.

use std::f32::consts::TAU;

mod block;
mod clear;
mod coat;
mod diffuse;
mod dispersion;
pub mod hero_channel;
mod layers;
mod lobes;
mod reflectance;

pub use block::LayerBlock;
pub use layers::{Boundary, Layers};

use lobes::{ChosenLobe, LobeProbabilities};
use reflectance::ClearReflectance;

use super::{
    Bsdf, BsdfEval, BsdfKind, BsdfSample, HeroChannel, Lobe,
    albedo::{self, FacetAlbedo},
    conductor::multiscatter_gain,
    fresnel::{is_total, mirrored, reflect, refract, schlick_term},
    microfacet::{Facets, Ggx},
    sheen,
};
use crate::math::{Frame, Rgb, Sample2D, Vec3, warp};

/// The layered BSDF: its layers, and values derived from them.
#[derive(Clone, Copy, Debug)]
pub struct Layered {
    layers: Layers,
    /// The albedos of the facets of the base and of the coat.
    albedo: FacetAlbedo,
    coat_albedo: FacetAlbedo,
}

/// The quantities that depend on `wo` only.
pub struct LobeState {
    /// `wo`, above the surface, in the frame of the facets.
    o: Vec3,
    /// The frame of the coat, in that of the facets; `None` where its normal is that of the surface.
    coat_frame: Option<Frame>,
    /// `wo` in the frame of the coat.
    coat_o: Vec3,
    /// Index on the other side over the one on this side.
    eta: f32,
    /// The parts of the three kinds of base.
    metal: f32,
    diffuse: f32,
    clear: f32,
    /// The fraction of light that reaches the coat, and the fraction that reaches the base.
    under_sheen: f32,
    under_coat: f32,
    metal_f0: Rgb,
    metal_gain: Rgb,
    clear_reflectance: ClearReflectance,
    clear_gain: Rgb,
    /// Reflectance over the diffuse base at normal incidence.
    over_f0: Rgb,
    /// Factor of `1 - over_albedo(wi)` for the diffuse base.
    diffuse_gain: f32,
    /// The chance that a sample of the diffuse base leaves on the other side.
    diffuse_passes: f32,
    probabilities: LobeProbabilities,
}

impl Layered {
    pub fn new(layers: Layers) -> Self {
        let layers = layers.between_media();
        let coat_facets = if layers.coat > 0.0 {
            layers.coat_facets
        } else {
            Ggx::SMOOTH
        };
        Self {
            layers,
            albedo: FacetAlbedo::new(&layers.facets),
            coat_albedo: FacetAlbedo::new(&coat_facets),
        }
    }

    /// The layers.
    pub fn layers(&self) -> &Layers {
        &self.layers
    }

    /// The albedo of the boundary over the diffuse base, for all channels alike; `f0` is the reflectance
    /// at normal incidence.
    fn over_albedo(&self, f0: Rgb, w: Vec3) -> f32 {
        let [a, b] = self.albedo.schlick(&self.layers.facets, w);
        (f0.max_component() * a + self.layers.specular * b).min(1.0)
    }

    /// All that depends on `wo` alone; `None` where it lies in the surface.
    fn lobe_state(&self, wo: Vec3) -> Option<LobeState> {
        let below = wo.z < 0.0;
        let o = self.layers.facet_from_surface(if below { mirrored(wo) } else { wo });
        if o.z <= 0.0 {
            return None;
        }
        let passes = self.layers.transmission > 0.0 || self.layers.diffuse_transmission > 0.0;
        let inside = below && self.layers.refraction() == Boundary::Solid && passes;
        let eta = if inside { 1.0 / self.layers.ior } else { self.layers.ior };
        let [metal, diffuse, clear] = self.layers.parts();

        let coat_frame = self.coat_frame(below);
        let coat_o = coat_frame.map_or(o, |frame| frame.to_local(o));
        let (mut under_sheen, mut coat) = (1.0, 0.0);
        if !inside {
            if !self.layers.sheen.is_black() {
                let albedo = self.layers.sheen.max_component() * sheen::albedo(self.layers.sheen_roughness, o.z);
                under_sheen -= albedo.min(1.0);
            }
            coat = self.albedo_of_coat(coat_o);
        }
        let under_coat = under_sheen * (1.0 - coat);

        let [a, b] = self.albedo.schlick(&self.layers.facets, o);
        let all = a + b;
        let metal_f0 = self.layers.thin_film.f0(self.layers.base_color, o.z);
        let metal_gain = multiscatter_gain(metal_f0, all);
        let f0 = self.layers.reflectance_of_boundary();
        let over_f0 = if diffuse > 0.0 {
            self.layers.thin_film.f0(f0, o.z).map(|r| r.min(self.layers.specular))
        } else {
            f0
        };
        let over = (over_f0.max_component() * a + self.layers.specular * b).min(1.0);
        let mean = if diffuse > 0.0 {
            let [a, b] = albedo::schlick_mean(self.albedo, &self.layers.facets);
            (over_f0.max_component() * a + self.layers.specular * b).min(0.999)
        } else {
            0.0
        };
        let (clear_reflectance, clear_gain) = if clear > 0.0 {
            let clear_reflectance = self.clear_reflectance(o.z, eta);
            let gain = self.clear_gain(&clear_reflectance, o, all, eta);
            (clear_reflectance, gain)
        } else {
            (ClearReflectance::NONE, Rgb::WHITE)
        };

        let [reflected, passed] = self.layers.diffuse_albedos();
        // Facets also reflect at other angles, so the probability has a lower bound.
        let least = 0.05;
        let opaque = metal * (metal_f0 * a + Rgb::gray(b)).max_component().max(least)
            + diffuse * over.max(least * self.layers.specular);
        let mut probabilities = LobeProbabilities {
            sheen: 1.0 - under_sheen,
            coat: under_sheen * coat,
            diffuse: under_coat * diffuse * (reflected + passed) * (1.0 - over),
            base: under_coat * (opaque + clear),
            opaque: opaque / (opaque + clear).max(f32::MIN_POSITIVE),
        };
        probabilities.scale()?;
        Some(LobeState {
            o,
            coat_frame,
            coat_o,
            eta,
            metal,
            diffuse,
            clear,
            under_sheen,
            under_coat,
            metal_f0,
            metal_gain,
            clear_reflectance,
            clear_gain,
            over_f0,
            diffuse_gain: (1.0 - over) / (1.0 - mean),
            diffuse_passes: passed / (reflected + passed).max(f32::MIN_POSITIVE),
            probabilities,
        })
    }

    /// The light that all facets of the base together reflect at the cosine `cos`, before masking.
    fn mirror_weight(&self, state: &LobeState, cos: f32) -> Rgb {
        let grazing = schlick_term(cos);
        let blend = |f0: Rgb, f90: f32| f0 * (1.0 - grazing) + Rgb::gray(f90 * grazing);
        let mut weight = Rgb::BLACK;
        if state.metal > 0.0 {
            weight += blend(state.metal_f0, 1.0) * state.metal_gain * state.metal;
        }
        if state.diffuse > 0.0 {
            weight += blend(state.over_f0, self.layers.specular) * state.diffuse;
        }
        if state.clear > 0.0 {
            weight += self.clear_shares(&state.clear_reflectance, cos, state.eta).0 * (state.clear_gain * state.clear);
        }
        weight * state.under_coat
    }

    /// The chance that a facet of the base, seen at the cosine `cos`, is sampled as a mirror.
    fn reflection_probability(&self, state: &LobeState, cos: f32) -> f32 {
        if state.clear == 0.0 {
            return 1.0;
        }
        let (reflect, pass) = self.clear_shares(&state.clear_reflectance, cos, state.eta);
        let (reflect, pass) = (reflect.max_component(), (self.layers.base_color * pass).max_component());
        let reflects = if reflect > 0.0 { reflect / (reflect + pass) } else { 0.0 };
        state.probabilities.opaque + (1.0 - state.probabilities.opaque) * reflects
    }

    /// The light that clear facets transmit at the cosine `cos`, before masking.
    fn passing_weight(&self, state: &LobeState, cos: f32) -> Rgb {
        let passed = self.clear_shares(&state.clear_reflectance, cos, state.eta).1;
        let all = self.layers.base_color * passed * (state.clear_gain * state.clear * state.under_coat);
        self.layers.hero.map_or(all, |hero| all * hero.weight())
    }

    /// All lobes that are not delta; `i` is seen from the side of `state.o`.
    fn eval_upright(&self, state: &LobeState, i: Vec3) -> BsdfEval {
        let (o, probabilities) = (state.o, &state.probabilities);
        let mut eval = BsdfEval::default();
        if i.z < 0.0 {
            if state.clear > 0.0 && !self.layers.facets.is_smooth() {
                let facet = match self.layers.refraction() {
                    Boundary::ThinWalled => self.layers.facets.reflection(o, mirrored(i)),
                    Boundary::Solid => self.layers.facets.transmission(o, i, state.eta),
                };
                if let Some(facet) = facet {
                    eval.glossy = self.passing_weight(state, facet.cos) * (facet.pdf * facet.masking);
                    eval.pdf = facet.pdf * probabilities.base * (1.0 - self.reflection_probability(state, facet.cos));
                }
            }
            if self.layers.diffuse_transmission > 0.0 {
                self.add_diffuse(state, i, &mut eval);
            }
            if !self.transmits() {
                self.add_coat(state, i, &mut eval);
            }
            return eval;
        }
        self.add_diffuse(state, i, &mut eval);
        if !self.layers.facets.is_smooth()
            && let Some(facet) = self.layers.facets.reflection(o, i)
        {
            eval.glossy += self.mirror_weight(state, facet.cos) * (facet.pdf * facet.masking);
            eval.pdf += facet.pdf * probabilities.base * self.reflection_probability(state, facet.cos);
        }
        self.add_coat(state, i, &mut eval);
        if probabilities.sheen > 0.0 {
            eval.diffuse += self.layers.sheen * sheen::f_cos(self.layers.sheen_roughness, o, i);
            eval.pdf += probabilities.sheen / TAU;
        }
        eval
    }

    /// The one direction of a delta lobe; `i` is seen from the side of `state.o`.
    fn delta(&self, i: Vec3, weight: Rgb, probability: f32, lobe: Lobe) -> BsdfSample {
        BsdfSample {
            wi: i,
            weight: weight / probability,
            diffuse: Rgb::BLACK,
            pdf: None,
            lobe,
            eta: 1.0,
        }
    }

    /// A direction, seen from the side of `state.o`.
    fn sample_upright(&self, state: &LobeState, uc: f32, u: Sample2D) -> Option<BsdfSample> {
        let o = state.o;
        let (i, lobe, eta) = match state.probabilities.choose(uc) {
            ChosenLobe::Sheen => (warp::square_to_hemisphere(u.square), Lobe::Diffuse, 1.0),
            ChosenLobe::Diffuse(uc) if uc < state.diffuse_passes => {
                let eta = if self.layers.refraction() == Boundary::Solid {
                    state.eta
                } else {
                    1.0
                };
                (mirrored(u.cosine_hemisphere()), Lobe::Transmission, eta)
            }
            ChosenLobe::Diffuse(_) => (u.cosine_hemisphere(), Lobe::Diffuse, 1.0),
            ChosenLobe::Coat => return self.sample_coat(state, u),
            ChosenLobe::Base(uc) if self.layers.facets.is_smooth() => return self.sample_smooth(state, uc),
            ChosenLobe::Base(uc) => {
                let h = self.layers.facets.sample_normal(o, u.square);
                let above = reflect(o, h);
                match (
                    uc < self.reflection_probability(state, o.dot(h)),
                    self.layers.refraction(),
                ) {
                    (true, _) => (above, Lobe::Specular, 1.0),
                    (false, Boundary::ThinWalled) => (mirrored(above), Lobe::Transmission, 1.0),
                    (false, Boundary::Solid) => (refract(o, h, state.eta)?, Lobe::Transmission, state.eta),
                }
            }
        };
        // What a steep facet sends to the wrong side is lost.
        if (i.z < 0.0) != (lobe == Lobe::Transmission) {
            return None;
        }
        self.weighted(state, i, lobe, eta)
    }

    /// The sample of `i`, seen from the side of `state.o`.
    fn weighted(&self, state: &LobeState, i: Vec3, lobe: Lobe, eta: f32) -> Option<BsdfSample> {
        let eval = self.eval_upright(state, i);
        (eval.pdf > 0.0).then(|| BsdfSample {
            wi: i,
            weight: eval.f_cos() / eval.pdf,
            diffuse: eval.diffuse / eval.pdf,
            pdf: Some(eval.pdf),
            lobe,
            eta,
        })
    }

    /// One of the two directions of a smooth base, by a fresh uniform number.
    fn sample_smooth(&self, state: &LobeState, uc: f32) -> Option<BsdfSample> {
        let o = state.o;
        let share = self.reflection_probability(state, o.z);
        if uc < share {
            let weight = self.mirror_weight(state, o.z);
            return Some(self.delta(
                mirror_image(o),
                weight,
                state.probabilities.base * share,
                Lobe::Specular,
            ));
        }
        let (i, eta) = match self.layers.refraction() {
            Boundary::ThinWalled => (-o, 1.0),
            Boundary::Solid => (refract(o, Vec3::Z, state.eta)?, state.eta),
        };
        let probability = state.probabilities.base * (1.0 - share);
        let sample = self.delta(i, self.passing_weight(state, o.z), probability, Lobe::Transmission);
        Some(BsdfSample { eta, ..sample })
    }
}

/// The mirror image of `o` in the surface.
fn mirror_image(o: Vec3) -> Vec3 {
    Vec3::new(-o.x, -o.y, o.z)
}

impl BsdfKind for Layered {
    type Prepared = Option<LobeState>;

    fn prepare(&self, wo: Vec3) -> Option<LobeState> {
        self.lobe_state(wo)
    }

    fn eval_prepared(&self, state: &Option<LobeState>, wo: Vec3, wi: Vec3) -> BsdfEval {
        let Some(state) = state else {
            return BsdfEval::default();
        };
        let i = self
            .layers
            .facet_from_surface(if wo.z < 0.0 { mirrored(wi) } else { wi });
        self.eval_upright(state, i)
    }

    fn sample_prepared(&self, state: &Option<LobeState>, wo: Vec3, uc: f32, u: Sample2D) -> Option<BsdfSample> {
        let uc = self.layers.hero.map_or(uc, |hero| hero.fresh(uc));
        let sample = self.sample_upright(state.as_ref()?, uc, u)?;
        let i = self.layers.surface_from_facet(sample.wi);
        let wi = if wo.z < 0.0 { mirrored(i) } else { i };
        Some(BsdfSample { wi, ..sample })
    }

    fn transmits(&self) -> bool {
        (self.layers.transmission > 0.0 || self.layers.diffuse_transmission > 0.0) && self.layers.metallic < 1.0
    }

    fn reflects_totally(&self, wo_z: f32) -> bool {
        self.layers.refraction() == Boundary::Solid && self.layers.is_clear() && is_total(wo_z, self.layers.ior)
    }

    fn straight(&self, wo: Vec3) -> Rgb {
        if !self.layers.is_clear() || !self.layers.facets.is_smooth() || self.layers.refraction() == Boundary::Solid {
            return Rgb::BLACK;
        }
        self.lobe_state(wo)
            .map_or(Rgb::BLACK, |state| self.passing_weight(&state, state.o.z))
    }

    fn reads_tangent(&self) -> bool {
        !self.layers.facets.is_isotropic()
    }

    fn reads_bitangent(&self) -> bool {
        self.reads_tangent() && self.layers.rotation.y != 0.0
    }

    fn mirror_bitangent(&mut self) {
        self.layers.rotation.y = -self.layers.rotation.y;
    }

    fn has_coat(&self) -> bool {
        self.layers.coat > 0.0
    }

    fn set_coat_normal(&mut self, normal: Vec3) {
        self.layers.coat_normal = normal;
    }

    fn is_delta(&self) -> bool {
        let diffuse = self.layers.metallic < 1.0 && self.layers.transmission < 1.0;
        let coated = self.layers.coat > 0.0 && !self.layers.coat_facets.is_smooth();
        self.layers.facets.is_smooth() && !diffuse && !coated && self.layers.sheen.is_black()
    }

    fn immersed(&self, outside: f32) -> Option<Bsdf> {
        Some(self.layers().immersed(outside).into())
    }

    fn disperses(&self) -> bool {
        self.layers().disperses()
    }

    fn for_channel(&self, hero: HeroChannel) -> Option<Bsdf> {
        Some(self.layers().for_channel(hero).into())
    }
}
