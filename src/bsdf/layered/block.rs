//! Layers on vectors: opaque surfaces of metal, of a diffuse base under a boundary, or of both, which may have a coat.
//!
//! All give the bits of [`Layered`] (tested). What most surfaces do without is left to that: light that passes, films,
//! sheen, brushed or perfectly smooth facets, and coats with a normal of their own.

use std::f32::consts::FRAC_1_PI;

use super::{Layered, coat::COAT_F0};
use crate::{
    bsdf::{
        Bsdf,
        albedo::{self, AlbedoBlock},
        block::{BsdfBlock, EvalBlock, SampleBlock, or_black},
        conductor::multiscatter_gain,
        fresnel::{reflect, schlick_term},
    },
    math::{
        Rgb, Sample2D, Vec2, Vec3,
        block::{Each, LANES, get, get_rgb, set, set_rgb},
        float::select,
        warp,
    },
};

/// Layered surfaces, number by number.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct LayerBlock {
    /// The directions to the viewers.
    wo: [Each; 3],
    base: AlbedoBlock,
    coat_facets: AlbedoBlock,
    base_color: [Each; 3],
    /// The reflectance over the diffuse base at normal incidence.
    over_f0: [Each; 3],
    specular: Each,
    metal: Each,
    diffuse: Each,
    diffuse_albedo: Each,
    /// The mean albedo over the diffuse base.
    over_mean: Each,
    coat: Each,
    // What depends on the viewers.
    metal_gain: [Each; 3],
    diffuse_gain: Each,
    under_coat: Each,
    probability_of_coat: Each,
    probability_of_diffuse: Each,
    probability_of_base: Each,
}

impl LayerBlock {
    /// The albedo of the boundary over the diffuse base, from the weights of its facets.
    #[inline(always)]
    fn over_albedo(&self, lane: usize, a: f32, b: f32) -> f32 {
        (get_rgb(&self.over_f0, lane).max_component() * a + self.specular[lane] * b).min(1.0)
    }
}

impl BsdfBlock for LayerBlock {
    type Kind = Layered;

    const EMPTY: Self = Self {
        wo: [[0.0; LANES]; 3],
        base: AlbedoBlock::EMPTY,
        coat_facets: AlbedoBlock::EMPTY,
        base_color: [[0.0; LANES]; 3],
        over_f0: [[0.0; LANES]; 3],
        specular: [0.0; LANES],
        metal: [0.0; LANES],
        diffuse: [0.0; LANES],
        diffuse_albedo: [0.0; LANES],
        over_mean: [0.0; LANES],
        coat: [0.0; LANES],
        metal_gain: [[0.0; LANES]; 3],
        diffuse_gain: [0.0; LANES],
        under_coat: [0.0; LANES],
        probability_of_coat: [0.0; LANES],
        probability_of_diffuse: [0.0; LANES],
        probability_of_base: [0.0; LANES],
    };

    fn kind(bsdf: &Bsdf) -> Option<&Layered> {
        match bsdf {
            Bsdf::Layered(layered) => Some(layered),
            _ => None,
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, layered: &Layered) -> bool {
        let lane = lane % LANES;
        let layers = &layered.layers;
        let is_opaque = layers.transmission == 0.0 && layers.diffuse_transmission == 0.0;
        let is_bare = layers.thin_film.weight == 0.0 && layers.sheen.is_black();
        let is_turned = layers.rotation != Vec2::X;
        let has_one_normal = layers.coat == 0.0 || layers.coat_normal == Vec3::Z;
        if !(is_opaque && is_bare && has_one_normal) || is_turned {
            return false;
        }
        if layers.coat == 0.0 {
            self.coat_facets.remove(lane);
        } else if !self.coat_facets.set(lane, layered.coat_albedo, &layers.coat_facets) {
            return false;
        }
        if !self.base.set(lane, layered.albedo, &layers.facets) {
            return false;
        }
        let [metal, diffuse, _] = layers.parts();
        let mut over_f0 = layers.reflectance_of_boundary();
        let mut over_mean = 0.0;
        if diffuse > 0.0 {
            over_f0 = over_f0.map(|r| r.min(layers.specular));
            let [a, b] = albedo::schlick_mean(layered.albedo, &layers.facets);
            over_mean = (over_f0.max_component() * a + layers.specular * b).min(0.999);
        }
        set_rgb(&mut self.base_color, lane, layers.base_color);
        set_rgb(&mut self.over_f0, lane, over_f0);
        self.specular[lane] = layers.specular;
        self.metal[lane] = metal;
        self.diffuse[lane] = diffuse;
        self.diffuse_albedo[lane] = layers.base_color.max_component();
        self.over_mean[lane] = over_mean;
        self.coat[lane] = layers.coat;
        true
    }

    #[inline(always)]
    fn set_view(&mut self, lane: usize, wo: Vec3) {
        set(&mut self.wo, lane % LANES, wo);
    }

    #[inline(always)]
    fn prepare(&mut self) {
        let of_base = self.base.schlick(&self.wo);
        let of_coat = self.coat_facets.schlick(&self.wo);
        let mut gains = [[0.0; LANES]; 3];
        let (mut diffuse_gains, mut under_coats) = ([0.0; LANES], [0.0; LANES]);
        let (mut coats, mut diffuses, mut bases) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let coat = self.coat[lane] * (COAT_F0 * of_coat[0][lane] + of_coat[1][lane]);
            let under_coat = 1.0 - coat;
            let (a, b) = (of_base[0][lane], of_base[1][lane]);
            let f0 = get_rgb(&self.base_color, lane);
            let gain = multiscatter_gain(f0, a + b);
            let over = self.over_albedo(lane, a, b);
            let least = 0.05;
            let reflected = f0 * a + Rgb::gray(b);
            let opaque = self.metal[lane] * reflected.max_component().max(least)
                + self.diffuse[lane] * over.max(least * self.specular[lane]);
            let diffuse = under_coat * self.diffuse[lane] * self.diffuse_albedo[lane] * (1.0 - over);
            let base = under_coat * opaque;
            let sum = coat + diffuse + base;
            let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
            set_rgb(&mut gains, lane, gain);
            diffuse_gains[lane] = (1.0 - over) / (1.0 - self.over_mean[lane]);
            under_coats[lane] = under_coat;
            coats[lane] = coat * scale;
            diffuses[lane] = diffuse * scale;
            bases[lane] = base * scale;
        }
        (self.metal_gain, self.diffuse_gain, self.under_coat) = (gains, diffuse_gains, under_coats);
        self.probability_of_coat = coats;
        self.probability_of_diffuse = diffuses;
        self.probability_of_base = bases;
    }

    #[inline(always)]
    fn eval(&self, wi: &[Each; 3]) -> EvalBlock {
        let of_base = self.base.schlick(wi);
        let mut out = EvalBlock::EMPTY;
        for lane in 0..LANES {
            let (o, i) = (get(&self.wo, lane), get(wi, lane));
            let over = self.over_albedo(lane, of_base[0][lane], of_base[1][lane]);
            let base_color = get_rgb(&self.base_color, lane);
            let under_coat = self.under_coat[lane];
            let passes = (1.0 - over) * self.diffuse_gain[lane];
            let diffuse = base_color * (self.diffuse[lane] * under_coat * passes * i.z * FRAC_1_PI);
            let pdf_of_diffuse = self.probability_of_diffuse[lane] * warp::cosine_hemisphere_pdf(i.z);

            let (facet, is_there) = self.base.facets(lane).mirror_facet(o, i);
            let grazing = schlick_term(facet.cos);
            let of_metal = base_color * (1.0 - grazing) + Rgb::gray(grazing);
            let over_diffuse =
                get_rgb(&self.over_f0, lane) * (1.0 - grazing) + Rgb::gray(self.specular[lane] * grazing);
            let weight =
                of_metal * get_rgb(&self.metal_gain, lane) * self.metal[lane] + over_diffuse * self.diffuse[lane];
            let of_base = weight * under_coat * (facet.pdf * facet.masking);
            let pdf_of_base = facet.pdf * self.probability_of_base[lane];

            let (coat, is_coat_there) = self.coat_facets.facets(lane).mirror_facet(o, i);
            let grazing = schlick_term(coat.cos);
            let f = self.coat[lane] * (COAT_F0 * (1.0 - grazing) + grazing);
            let of_coat = f * coat.pdf * coat.masking;
            let pdf_of_coat = self.probability_of_coat[lane] * coat.pdf;

            let is_lit = i.z > 0.0;
            let is_there = is_lit & is_there;
            let is_coated = is_lit & is_coat_there & (self.probability_of_coat[lane] > 0.0);
            let of_coat = if is_coated { of_coat } else { 0.0 };
            set_rgb(&mut out.diffuse, lane, or_black(is_lit, diffuse));
            set_rgb(&mut out.glossy, lane, or_black(is_there, of_base) + Rgb::gray(of_coat));
            let pdf_of_diffuse = if is_lit { pdf_of_diffuse } else { 0.0 };
            let pdf_of_base = if is_there { pdf_of_base } else { 0.0 };
            out.pdf[lane] = pdf_of_diffuse + pdf_of_base + if is_coated { pdf_of_coat } else { 0.0 };
        }
        out
    }

    #[inline(always)]
    fn sample(&self, choices: &Each, samples: &Each<Sample2D>) -> SampleBlock {
        let mut out = SampleBlock::EMPTY;
        // 0 where the direction is lost.
        let mut kept = [0.0; LANES];
        let (mut directions, mut diffuse_lobes) = ([[0.0; LANES]; 3], [0_u32; LANES]);
        for lane in 0..LANES {
            let rest = choices[lane] - self.probability_of_coat[lane];
            let is_coat = choices[lane] < self.probability_of_coat[lane];
            let is_below = (rest < self.probability_of_diffuse[lane]) | (self.probability_of_base[lane] <= 0.0);
            let is_diffuse = !is_coat & is_below;
            let o = get(&self.wo, lane);
            let mut facets = self.base.facets(lane);
            let coat_alpha = self.coat_facets.alpha[lane];
            facets.alpha.x = if is_coat { coat_alpha } else { facets.alpha.x };
            facets.alpha.y = if is_coat { coat_alpha } else { facets.alpha.y };
            let mirrored = reflect(o, facets.visible_normal(o, samples[lane].square));
            let mirrored = select(is_coat, mirrored.normalize(), mirrored);
            let i = select(is_diffuse, samples[lane].cosine_hemisphere(), mirrored);
            let is_above = (i.z > 0.0) | (!is_coat & (i.z >= 0.0));
            kept[lane] = if is_above { 1.0 } else { 0.0 };
            set(&mut directions, lane, i);
            diffuse_lobes[lane] = u32::from(is_diffuse);
        }
        let eval = self.eval(&directions);
        for (lane, kept) in kept.iter().enumerate() {
            let (diffuse, glossy) = (get_rgb(&eval.diffuse, lane), get_rgb(&eval.glossy, lane));
            let pdf = eval.pdf[lane];
            set_rgb(&mut out.weight, lane, (diffuse + glossy) / pdf);
            set_rgb(&mut out.diffuse, lane, diffuse / pdf);
            out.pdf[lane] = pdf * kept;
        }
        (out.wi, out.is_diffuse) = (directions, diffuse_lobes);
        out
    }
}
