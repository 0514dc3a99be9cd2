//! The surface of all trades: a sheen over a clear coat over a mixture of metal, of a clear boundary, and of a clear boundary
//! over chalk.
//!
//! Each layer takes the part of the light that it reflects; what is left goes to the layers below. So white layers lose nothing
//! and never gain. Light is shared out by what the layers reflect towards the viewer, so exchanging `wo` and `wi` does not give
//! the very same value.

use std::f32::consts::{FRAC_1_PI, TAU};

mod clear;

use clear::Shine;

use super::{
    BsdfEval, BsdfKind, BsdfSample, Lobe, albedo,
    conductor::bounced,
    film::Film,
    fresnel::{mirrored, reflect, refract, schlick_term},
    microfacet::Ggx,
    sheen,
};
use crate::math::{Draw, Rgb, Vec2, Vec3, warp};

/// Whether there is a medium behind the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Walls {
    /// No: the surface is a sheet, and light goes straight on.
    Thin,
    /// Yes: light is refracted.
    Solid,
}

/// The reflectance of a clear coat at normal incidence: an index of refraction of 1.5.
const COAT_F0: f32 = 0.04;

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct Layered {
    /// Of metal at normal incidence, of chalk, and of what passes.
    pub base_color: Rgb,
    /// The part that is metal.
    pub metallic: f32,
    /// The part of the rest that is clear.
    pub transmission: f32,
    /// Of metal and of boundaries; even where light passes into a solid.
    pub facets: Ggx,
    /// Cosine and sine of the angle from the frame's tangent to that of the facets.
    pub turn: Vec2,
    /// Index of refraction behind the surface over that in front.
    pub ior: f32,
    pub walls: Walls,
    /// Strength of the boundary's reflection.
    pub specular: f32,
    /// Colour of the boundary's reflection at normal incidence.
    pub specular_color: Rgb,
    pub film: Film,
    /// The part that is coated.
    pub coat: f32,
    pub coat_facets: Ggx,
    pub sheen: Rgb,
    pub sheen_roughness: f32,
}

impl Default for Layered {
    /// White chalk under a rough clear boundary.
    fn default() -> Self {
        Self {
            base_color: Rgb::WHITE,
            metallic: 0.0,
            transmission: 0.0,
            facets: Ggx::new(Vec2::ONE),
            turn: Vec2::X,
            ior: 1.5,
            walls: Walls::Thin,
            specular: 1.0,
            specular_color: Rgb::WHITE,
            film: Film::NONE,
            coat: 0.0,
            coat_facets: Ggx::SMOOTH,
            sheen: Rgb::BLACK,
            sheen_roughness: 0.0,
        }
    }
}

/// The chances of the lobes.
#[derive(Clone, Copy, Debug, Default)]
struct Chances {
    sheen: f32,
    coat: f32,
    diffuse: f32,
    /// The facets of the base.
    base: f32,
    /// The part of `base` that is of facets that let nothing pass.
    blind: f32,
}

/// All that depends on `wo` alone.
struct View {
    /// `wo`, above the surface, in the frame of the facets.
    o: Vec3,
    /// Index on the other side over the one on this side.
    eta: f32,
    /// The parts of the three kinds of base.
    metal: f32,
    chalk: f32,
    clear: f32,
    /// What reaches the coat, and what reaches the base.
    under_sheen: f32,
    under_coat: f32,
    metal_f0: Rgb,
    metal_gain: Rgb,
    shine: Shine,
    clear_gain: Rgb,
    /// Reflectance over chalk at normal incidence.
    over_f0: Rgb,
    /// Factor of `1 - over_albedo(wi)` for chalk.
    chalk_gain: f32,
    chances: Chances,
}

impl Layered {
    fn normal_reflectance(&self) -> f32 {
        let r = (self.ior - 1.0) / (self.ior + 1.0);
        r * r
    }

    /// What the boundary reflects at normal incidence, without a film.
    pub fn reflectance_of_boundary(&self) -> Rgb {
        let f0 = self.normal_reflectance();
        self.specular_color.map(|c| (c * f0).min(1.0)) * self.specular
    }

    /// What the boundary over chalk reflects, whatever the colour, of which `f0` is that at normal incidence.
    fn over_albedo(&self, f0: Rgb, w: Vec3) -> f32 {
        let [a, b] = albedo::schlick(&self.facets, w);
        (f0.max_component() * a + self.specular * b).min(1.0)
    }

    /// All that depends on `wo` alone; `None` where it lies in the surface.
    fn view(&self, wo: Vec3) -> Option<View> {
        let below = wo.z < 0.0;
        let o = self.turned(if below { mirrored(wo) } else { wo });
        if o.z <= 0.0 {
            return None;
        }
        let inside = below && self.walls == Walls::Solid && self.transmission > 0.0;
        let eta = if inside { 1.0 / self.ior } else { self.ior };
        let metal = self.metallic;
        let clear = (1.0 - metal) * self.transmission;
        let chalk = (1.0 - metal - clear).max(0.0);

        let (mut under_sheen, mut coat) = (1.0, 0.0);
        if !inside {
            if !self.sheen.is_black() {
                let albedo = self.sheen.max_component() * sheen::albedo(self.sheen_roughness, o.z);
                under_sheen -= albedo.min(1.0);
            }
            if self.coat > 0.0 {
                let [a, b] = albedo::schlick(&self.coat_facets, o);
                coat = self.coat * (COAT_F0 * a + b);
            }
        }
        let under_coat = under_sheen * (1.0 - coat);

        let [a, b] = albedo::schlick(&self.facets, o);
        let all = a + b;
        let metal_f0 = self.film.f0(self.base_color, o.z);
        let metal_gain = bounced(metal_f0, all);
        let f0 = self.reflectance_of_boundary();
        let over_f0 = if chalk > 0.0 {
            self.film.f0(f0, o.z).map(|r| r.min(self.specular))
        } else {
            f0
        };
        let over = (over_f0.max_component() * a + self.specular * b).min(1.0);
        let mean = {
            let [a, b] = albedo::schlick_mean(&self.facets);
            (over_f0.max_component() * a + self.specular * b).min(0.999)
        };
        let (shine, clear_gain) = if clear > 0.0 {
            let shine = self.shine(o.z, eta);
            let gain = self.clear_gain(&shine, o, all, eta);
            (shine, gain)
        } else {
            (Shine::NONE, Rgb::WHITE)
        };

        let color = self.base_color.max_component();
        // What facets seen from here reflect at other angles is not nothing.
        let least = 0.05;
        let blind =
            metal * (metal_f0 * a + Rgb::gray(b)).max_component().max(least) + chalk * over.max(least * self.specular);
        let mut chances = Chances {
            sheen: 1.0 - under_sheen,
            coat: under_sheen * coat,
            diffuse: under_coat * chalk * color * (1.0 - over),
            base: under_coat * (blind + clear),
            blind: blind / (blind + clear).max(f32::MIN_POSITIVE),
        };
        chances.scale()?;
        Some(View {
            o,
            eta,
            metal,
            chalk,
            clear,
            under_sheen,
            under_coat,
            metal_f0,
            metal_gain,
            shine,
            clear_gain,
            over_f0,
            chalk_gain: (1.0 - over) / (1.0 - mean),
            chances,
        })
    }

    /// `w` in the frame of the facets.
    fn turned(&self, w: Vec3) -> Vec3 {
        Vec3::new(
            w.x * self.turn.x + w.y * self.turn.y,
            w.y * self.turn.x - w.x * self.turn.y,
            w.z,
        )
    }

    /// `w`, given in the frame of the facets.
    fn turned_back(&self, w: Vec3) -> Vec3 {
        Vec3::new(
            w.x * self.turn.x - w.y * self.turn.y,
            w.y * self.turn.x + w.x * self.turn.y,
            w.z,
        )
    }

    /// What all facets of the base together reflect at the cosine `cos`, before it is hidden.
    fn mirror_weight(&self, view: &View, cos: f32) -> Rgb {
        let grazing = schlick_term(cos);
        let blend = |f0: Rgb, f90: f32| f0 * (1.0 - grazing) + Rgb::gray(f90 * grazing);
        let mut weight = Rgb::BLACK;
        if view.metal > 0.0 {
            weight += blend(view.metal_f0, 1.0) * view.metal_gain * view.metal;
        }
        if view.chalk > 0.0 {
            weight += blend(view.over_f0, self.specular) * view.chalk;
        }
        if view.clear > 0.0 {
            weight += self.clear_shares(&view.shine, cos, view.eta).0 * (view.clear_gain * view.clear);
        }
        weight * view.under_coat
    }

    /// The chance that a facet of the base, seen at the cosine `cos`, is sampled as a mirror.
    fn share_of_mirrors(&self, view: &View, cos: f32) -> f32 {
        if view.clear == 0.0 {
            return 1.0;
        }
        let (reflect, pass) = self.clear_shares(&view.shine, cos, view.eta);
        let (reflect, pass) = (reflect.max_component(), (self.base_color * pass).max_component());
        let reflects = if reflect > 0.0 { reflect / (reflect + pass) } else { 0.0 };
        view.chances.blind + (1.0 - view.chances.blind) * reflects
    }

    /// What clear facets let pass at the cosine `cos`, before it is hidden.
    fn passing_weight(&self, view: &View, cos: f32) -> Rgb {
        let passed = self.clear_shares(&view.shine, cos, view.eta).1;
        self.base_color * passed * (view.clear_gain * view.clear * view.under_coat)
    }

    /// All lobes that are not delta; `i` is seen from the side of `view.o`.
    fn eval_upright(&self, view: &View, i: Vec3) -> BsdfEval {
        let (o, chances) = (view.o, &view.chances);
        let mut eval = BsdfEval::default();
        if i.z < 0.0 {
            if view.clear > 0.0 && !self.facets.is_smooth() {
                let facet = match self.walls {
                    Walls::Thin => self.facets.reflection(o, mirrored(i)),
                    Walls::Solid => self.facets.transmission(o, i, view.eta),
                };
                if let Some(facet) = facet {
                    eval.glossy = self.passing_weight(view, facet.cos) * (facet.pdf * facet.seen);
                    eval.pdf = facet.pdf * chances.base * (1.0 - self.share_of_mirrors(view, facet.cos));
                }
            }
            return eval;
        }
        if view.chalk > 0.0 {
            let passes = (1.0 - self.over_albedo(view.over_f0, i)) * view.chalk_gain;
            eval.diffuse = self.base_color * (view.chalk * view.under_coat * passes * i.z * FRAC_1_PI);
            eval.pdf += chances.diffuse * warp::cosine_hemisphere_pdf(i.z);
        }
        if !self.facets.is_smooth()
            && let Some(facet) = self.facets.reflection(o, i)
        {
            eval.glossy += self.mirror_weight(view, facet.cos) * (facet.pdf * facet.seen);
            eval.pdf += facet.pdf * chances.base * self.share_of_mirrors(view, facet.cos);
        }
        if chances.coat > 0.0
            && !self.coat_facets.is_smooth()
            && let Some(facet) = self.coat_facets.reflection(o, i)
        {
            let f = self.coat_weight(view, facet.cos);
            eval.glossy += Rgb::gray(f * facet.pdf * facet.seen);
            eval.pdf += chances.coat * facet.pdf;
        }
        if chances.sheen > 0.0 {
            eval.diffuse += self.sheen * sheen::f_cos(self.sheen_roughness, o, i);
            eval.pdf += chances.sheen / TAU;
        }
        eval
    }

    /// What the coat's facets reflect at the cosine `cos`.
    fn coat_weight(&self, view: &View, cos: f32) -> f32 {
        let grazing = schlick_term(cos);
        self.coat * view.under_sheen * (COAT_F0 * (1.0 - grazing) + grazing)
    }

    /// The one direction of a delta lobe; `i` is seen from the side of `view.o`.
    fn delta(&self, i: Vec3, weight: Rgb, chance: f32, lobe: Lobe) -> BsdfSample {
        BsdfSample {
            wi: i,
            weight: weight / chance,
            diffuse: Rgb::BLACK,
            pdf: None,
            lobe,
            eta: 1.0,
        }
    }

    /// A direction, seen from the side of `view.o`.
    fn sample_upright(&self, view: &View, uc: f32, u: Draw) -> Option<BsdfSample> {
        let o = view.o;
        let (i, lobe, eta) = match view.chances.choose(uc) {
            Choice::Sheen => (warp::square_to_hemisphere(u.square), Lobe::Diffuse, 1.0),
            Choice::Diffuse => (u.cosine_hemisphere(), Lobe::Diffuse, 1.0),
            Choice::Coat if self.coat_facets.is_smooth() => {
                let weight = Rgb::gray(self.coat_weight(view, o.z));
                return Some(self.delta(mirror_image(o), weight, view.chances.coat, Lobe::Specular));
            }
            Choice::Coat => (self.coat_facets.sample_reflection(o, u.square)?, Lobe::Specular, 1.0),
            Choice::Base(uc) if self.facets.is_smooth() => return self.sample_smooth(view, uc),
            Choice::Base(uc) => {
                let h = self.facets.sample_normal(o, u.square);
                let above = reflect(o, h);
                match (uc < self.share_of_mirrors(view, o.dot(h)), self.walls) {
                    (true, _) => (above, Lobe::Specular, 1.0),
                    (false, Walls::Thin) => (mirrored(above), Lobe::Transmission, 1.0),
                    (false, Walls::Solid) => (refract(o, h, view.eta)?, Lobe::Transmission, view.eta),
                }
            }
        };
        // What a steep facet sends to the wrong side is lost.
        if (i.z < 0.0) != (lobe == Lobe::Transmission) {
            return None;
        }
        let eval = self.eval_upright(view, i);
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
    fn sample_smooth(&self, view: &View, uc: f32) -> Option<BsdfSample> {
        let o = view.o;
        let share = self.share_of_mirrors(view, o.z);
        if uc < share {
            let weight = self.mirror_weight(view, o.z);
            return Some(self.delta(mirror_image(o), weight, view.chances.base * share, Lobe::Specular));
        }
        let (i, eta) = match self.walls {
            Walls::Thin => (-o, 1.0),
            Walls::Solid => (refract(o, Vec3::Z, view.eta)?, view.eta),
        };
        let chance = view.chances.base * (1.0 - share);
        let sample = self.delta(i, self.passing_weight(view, o.z), chance, Lobe::Transmission);
        Some(BsdfSample { eta, ..sample })
    }
}

/// The mirror image of `o` in the surface.
fn mirror_image(o: Vec3) -> Vec3 {
    Vec3::new(-o.x, -o.y, o.z)
}

enum Choice {
    Sheen,
    Coat,
    Diffuse,
    /// With a fresh uniform number.
    Base(f32),
}

impl Chances {
    /// Makes their sum 1; `None` where it is 0.
    fn scale(&mut self) -> Option<()> {
        let sum = self.sheen + self.coat + self.diffuse + self.base;
        if sum <= 0.0 {
            return None;
        }
        for chance in [&mut self.sheen, &mut self.coat, &mut self.diffuse, &mut self.base] {
            *chance /= sum;
        }
        Some(())
    }

    /// The lobe of the uniform number `uc`.
    fn choose(&self, uc: f32) -> Choice {
        let mut rest = uc;
        for (chance, choice) in [
            (self.sheen, Choice::Sheen),
            (self.coat, Choice::Coat),
            (self.diffuse, Choice::Diffuse),
        ] {
            if rest < chance {
                return choice;
            }
            rest -= chance;
        }
        if self.base > 0.0 {
            Choice::Base((rest / self.base).min(1.0 - f32::EPSILON))
        } else {
            // Rounding went past the last of them.
            Choice::Diffuse
        }
    }
}

impl BsdfKind for Layered {
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let Some(view) = self.view(wo) else {
            return BsdfEval::default();
        };
        let i = self.turned(if wo.z < 0.0 { mirrored(wi) } else { wi });
        self.eval_upright(&view, i)
    }

    fn sample(&self, wo: Vec3, uc: f32, u: Draw) -> Option<BsdfSample> {
        let view = self.view(wo)?;
        let sample = self.sample_upright(&view, uc, u)?;
        let i = self.turned_back(sample.wi);
        let wi = if wo.z < 0.0 { mirrored(i) } else { i };
        Some(BsdfSample { wi, ..sample })
    }

    fn transmits(&self) -> bool {
        self.transmission > 0.0 && self.metallic < 1.0
    }

    fn reads_tangent(&self) -> bool {
        !self.facets.is_even()
    }

    fn is_delta(&self) -> bool {
        let chalk = self.metallic < 1.0 && self.transmission < 1.0;
        let coated = self.coat > 0.0 && !self.coat_facets.is_smooth();
        self.facets.is_smooth() && !chalk && !coated && self.sheen.is_black()
    }
}
