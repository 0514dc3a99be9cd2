//! The layered BSDF of the principled material: sheen over a clear coat over a blend of metal, a
//! transmitting dielectric, and a dielectric over a diffuse base, which may pass light on to the other
//! side.
//!
//! Each layer reflects a part of the light and passes the rest to the layers below, so white layers
//! neither lose nor gain energy. The parts are the albedos of the layers towards the viewer, so the
//! BSDF is not exactly reciprocal.

use std::f32::consts::TAU;

mod clear;
mod coat;
mod diffuse;
mod dispersion;
pub mod hero_channel;
mod lobes;
mod reflectance;

use hero_channel::HeroChannel;
use lobes::{ChosenLobe, LobeProbabilities};
use reflectance::ClearReflectance;

use super::{
    BsdfEval, BsdfKind, BsdfSample, Lobe, albedo,
    conductor::multiscatter_gain,
    fresnel::{is_total, mirrored, reflect, refract, schlick_term},
    is_equal_ior,
    microfacet::Ggx,
    sheen,
    thin_film::ThinFilm,
};
use crate::math::{Frame, Rgb, Sample2D, Vec2, Vec3, warp};

/// The boundary of a surface: a thin sheet or a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// A thin sheet; light is transmitted without refraction.
    ThinWalled,
    /// The boundary of a volume; light is refracted.
    Solid,
}

/// The layered BSDF; see the module.
#[derive(Clone, Copy, Debug)]
pub struct Layered {
    /// The colour of metal at normal incidence, of the diffuse base, and of transmitted light.
    pub base_color: Rgb,
    /// The part that is metal.
    pub metallic: f32,
    /// The part of the rest that is clear.
    pub transmission: f32,
    /// The part of the diffuse base's light that leaves on the other side, and its colour.
    pub diffuse_transmission: f32,
    pub diffuse_transmission_color: Rgb,
    /// The facets of metal and of boundaries; isotropic where light passes into a solid.
    pub facets: Ggx,
    /// Cosine and sine of the angle from the frame's first axis to that of the facets, towards the second one.
    pub rotation: Vec2,
    /// Index of refraction behind the surface over that in front.
    pub ior: f32,
    /// 20 over the Abbe number of a solid; 0 is none.
    pub dispersion: f32,
    /// The channel whose index `ior` is, in a dispersive solid.
    pub hero: Option<HeroChannel>,
    pub boundary: Boundary,
    /// Strength of the boundary's reflection.
    pub specular: f32,
    /// Colour of the boundary's reflection at normal incidence.
    pub specular_color: Rgb,
    pub thin_film: ThinFilm,
    /// The part that is coated.
    pub coat: f32,
    pub coat_facets: Ggx,
    /// The unit normal of the coat on the front, in the shading frame.
    pub coat_normal: Vec3,
    pub sheen: Rgb,
    pub sheen_roughness: f32,
}

impl Default for Layered {
    /// A white diffuse base under a rough dielectric.
    fn default() -> Self {
        Self {
            base_color: Rgb::WHITE,
            metallic: 0.0,
            transmission: 0.0,
            diffuse_transmission: 0.0,
            diffuse_transmission_color: Rgb::WHITE,
            facets: Ggx::new(Vec2::ONE),
            rotation: Vec2::X,
            ior: 1.5,
            dispersion: 0.0,
            hero: None,
            boundary: Boundary::ThinWalled,
            specular: 1.0,
            specular_color: Rgb::WHITE,
            thin_film: ThinFilm::NONE,
            coat: 0.0,
            coat_facets: Ggx::SMOOTH,
            coat_normal: Vec3::Z,
            sheen: Rgb::BLACK,
            sheen_roughness: 0.0,
        }
    }
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
    /// Reflectance over chalk at normal incidence.
    over_f0: Rgb,
    /// Factor of `1 - over_albedo(wi)` for chalk.
    diffuse_gain: f32,
    /// The chance that a sample of chalk leaves on the other side.
    diffuse_passes: f32,
    probabilities: LobeProbabilities,
}

impl Layered {
    fn normal_reflectance(&self) -> f32 {
        let r = (self.ior - 1.0) / (self.ior + 1.0);
        r * r
    }

    /// The reflectance of the boundary at normal incidence, without a thin film.
    pub fn reflectance_of_boundary(&self) -> Rgb {
        let f0 = self.normal_reflectance();
        self.specular_color.map(|c| (c * f0).min(1.0)) * self.specular
    }

    /// Whether a part of it is a clear boundary.
    fn is_clear(&self) -> bool {
        self.transmission > 0.0 && self.metallic < 1.0
    }

    /// The albedo of the boundary over the diffuse base, for all channels alike; `f0` is the reflectance
    /// at normal incidence.
    fn over_albedo(&self, f0: Rgb, w: Vec3) -> f32 {
        let [a, b] = albedo::schlick(&self.facets, w);
        (f0.max_component() * a + self.specular * b).min(1.0)
    }

    /// All that depends on `wo` alone; `None` where it lies in the surface.
    fn lobe_state(&self, wo: Vec3) -> Option<LobeState> {
        let below = wo.z < 0.0;
        let o = self.facet_from_surface(if below { mirrored(wo) } else { wo });
        if o.z <= 0.0 {
            return None;
        }
        let passes = self.transmission > 0.0 || self.diffuse_transmission > 0.0;
        let inside = below && self.boundary == Boundary::Solid && passes;
        let eta = if inside { 1.0 / self.ior } else { self.ior };
        let metal = self.metallic;
        let clear = (1.0 - metal) * self.transmission;
        let diffuse = (1.0 - metal - clear).max(0.0);

        let coat_frame = self.coat_frame(below);
        let coat_o = coat_frame.map_or(o, |frame| frame.to_local(o));
        let (mut under_sheen, mut coat) = (1.0, 0.0);
        if !inside {
            if !self.sheen.is_black() {
                let albedo = self.sheen.max_component() * sheen::albedo(self.sheen_roughness, o.z);
                under_sheen -= albedo.min(1.0);
            }
            coat = self.coat_albedo(coat_o);
        }
        let under_coat = under_sheen * (1.0 - coat);

        let [a, b] = albedo::schlick(&self.facets, o);
        let all = a + b;
        let metal_f0 = self.thin_film.f0(self.base_color, o.z);
        let metal_gain = multiscatter_gain(metal_f0, all);
        let f0 = self.reflectance_of_boundary();
        let over_f0 = if diffuse > 0.0 {
            self.thin_film.f0(f0, o.z).map(|r| r.min(self.specular))
        } else {
            f0
        };
        let over = (over_f0.max_component() * a + self.specular * b).min(1.0);
        let mean = {
            let [a, b] = albedo::schlick_mean(&self.facets);
            (over_f0.max_component() * a + self.specular * b).min(0.999)
        };
        let (clear_reflectance, clear_gain) = if clear > 0.0 {
            let clear_reflectance = self.clear_reflectance(o.z, eta);
            let gain = self.clear_gain(&clear_reflectance, o, all, eta);
            (clear_reflectance, gain)
        } else {
            (ClearReflectance::NONE, Rgb::WHITE)
        };

        let reflected = self.base_color.max_component() * (1.0 - self.diffuse_transmission);
        let passed = self.diffuse_transmission_color.max_component() * self.diffuse_transmission;
        // What facets seen from here reflect at other angles is not nothing.
        let least = 0.05;
        let opaque = metal * (metal_f0 * a + Rgb::gray(b)).max_component().max(least)
            + diffuse * over.max(least * self.specular);
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

    /// The same layers in a medium of the index of refraction `outside`, in place of 1.
    pub fn immersed(self, outside: f32) -> Self {
        let ior = self.ior / outside;
        let boundary = if is_equal_ior(ior, 1.0) {
            Boundary::ThinWalled
        } else {
            self.boundary
        };
        Self { ior, boundary, ..self }
    }

    /// `w` in the frame of the facets.
    fn facet_from_surface(&self, w: Vec3) -> Vec3 {
        Vec3::new(
            w.x * self.rotation.x + w.y * self.rotation.y,
            w.y * self.rotation.x - w.x * self.rotation.y,
            w.z,
        )
    }

    /// `w`, given in the frame of the facets.
    fn surface_from_facet(&self, w: Vec3) -> Vec3 {
        Vec3::new(
            w.x * self.rotation.x - w.y * self.rotation.y,
            w.y * self.rotation.x + w.x * self.rotation.y,
            w.z,
        )
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
            weight += blend(state.over_f0, self.specular) * state.diffuse;
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
        let (reflect, pass) = (reflect.max_component(), (self.base_color * pass).max_component());
        let reflects = if reflect > 0.0 { reflect / (reflect + pass) } else { 0.0 };
        state.probabilities.opaque + (1.0 - state.probabilities.opaque) * reflects
    }

    /// The light that clear facets transmit at the cosine `cos`, before masking.
    fn passing_weight(&self, state: &LobeState, cos: f32) -> Rgb {
        let passed = self.clear_shares(&state.clear_reflectance, cos, state.eta).1;
        let all = self.base_color * passed * (state.clear_gain * state.clear * state.under_coat);
        self.hero.map_or(all, |hero| all * hero.weight())
    }

    /// All lobes that are not delta; `i` is seen from the side of `view.o`.
    fn eval_upright(&self, state: &LobeState, i: Vec3) -> BsdfEval {
        let (o, probabilities) = (state.o, &state.probabilities);
        let mut eval = BsdfEval::default();
        if i.z < 0.0 {
            if state.clear > 0.0 && !self.facets.is_smooth() {
                let facet = match self.boundary {
                    Boundary::ThinWalled => self.facets.reflection(o, mirrored(i)),
                    Boundary::Solid => self.facets.transmission(o, i, state.eta),
                };
                if let Some(facet) = facet {
                    eval.glossy = self.passing_weight(state, facet.cos) * (facet.pdf * facet.masking);
                    eval.pdf = facet.pdf * probabilities.base * (1.0 - self.reflection_probability(state, facet.cos));
                }
            }
            if self.diffuse_transmission > 0.0 {
                self.add_diffuse(state, i, &mut eval);
            }
            if !self.transmits() {
                self.add_coat(state, i, &mut eval);
            }
            return eval;
        }
        self.add_diffuse(state, i, &mut eval);
        if !self.facets.is_smooth()
            && let Some(facet) = self.facets.reflection(o, i)
        {
            eval.glossy += self.mirror_weight(state, facet.cos) * (facet.pdf * facet.masking);
            eval.pdf += facet.pdf * probabilities.base * self.reflection_probability(state, facet.cos);
        }
        self.add_coat(state, i, &mut eval);
        if probabilities.sheen > 0.0 {
            eval.diffuse += self.sheen * sheen::f_cos(self.sheen_roughness, o, i);
            eval.pdf += probabilities.sheen / TAU;
        }
        eval
    }

    /// The one direction of a delta lobe; `i` is seen from the side of `view.o`.
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

    /// A direction, seen from the side of `view.o`.
    fn sample_upright(&self, state: &LobeState, uc: f32, u: Sample2D) -> Option<BsdfSample> {
        let o = state.o;
        let (i, lobe, eta) = match state.probabilities.choose(uc) {
            ChosenLobe::Sheen => (warp::square_to_hemisphere(u.square), Lobe::Diffuse, 1.0),
            ChosenLobe::Diffuse(uc) if uc < state.diffuse_passes => {
                let eta = if self.boundary == Boundary::Solid {
                    state.eta
                } else {
                    1.0
                };
                (mirrored(u.cosine_hemisphere()), Lobe::Transmission, eta)
            }
            ChosenLobe::Diffuse(_) => (u.cosine_hemisphere(), Lobe::Diffuse, 1.0),
            ChosenLobe::Coat => return self.sample_coat(state, u),
            ChosenLobe::Base(uc) if self.facets.is_smooth() => return self.sample_smooth(state, uc),
            ChosenLobe::Base(uc) => {
                let h = self.facets.sample_normal(o, u.square);
                let above = reflect(o, h);
                match (uc < self.reflection_probability(state, o.dot(h)), self.boundary) {
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

    /// The sample of `i`, seen from the side of `view.o`.
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
        let (i, eta) = match self.boundary {
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
        let i = self.facet_from_surface(if wo.z < 0.0 { mirrored(wi) } else { wi });
        self.eval_upright(state, i)
    }

    fn sample_prepared(&self, state: &Option<LobeState>, wo: Vec3, uc: f32, u: Sample2D) -> Option<BsdfSample> {
        let uc = self.hero.map_or(uc, |hero| hero.fresh(uc));
        let sample = self.sample_upright(state.as_ref()?, uc, u)?;
        let i = self.surface_from_facet(sample.wi);
        let wi = if wo.z < 0.0 { mirrored(i) } else { i };
        Some(BsdfSample { wi, ..sample })
    }

    fn transmits(&self) -> bool {
        (self.transmission > 0.0 || self.diffuse_transmission > 0.0) && self.metallic < 1.0
    }

    fn reflects_totally(&self, wo_z: f32) -> bool {
        self.boundary == Boundary::Solid && self.is_clear() && is_total(wo_z, self.ior)
    }

    fn straight(&self, wo: Vec3) -> Rgb {
        if !self.is_clear() || !self.facets.is_smooth() || self.boundary == Boundary::Solid {
            return Rgb::BLACK;
        }
        self.lobe_state(wo)
            .map_or(Rgb::BLACK, |state| self.passing_weight(&state, state.o.z))
    }

    fn reads_tangent(&self) -> bool {
        !self.facets.is_isotropic()
    }

    fn reads_bitangent(&self) -> bool {
        self.reads_tangent() && self.rotation.y != 0.0
    }

    fn mirror_bitangent(&mut self) {
        self.rotation.y = -self.rotation.y;
    }

    fn has_coat(&self) -> bool {
        self.coat > 0.0
    }

    fn set_coat_normal(&mut self, normal: Vec3) {
        self.coat_normal = normal;
    }

    fn is_delta(&self) -> bool {
        let diffuse = self.metallic < 1.0 && self.transmission < 1.0;
        let coated = self.coat > 0.0 && !self.coat_facets.is_smooth();
        self.facets.is_smooth() && !diffuse && !coated && self.sheen.is_black()
    }
}
