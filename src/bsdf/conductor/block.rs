//! Rough even conductors on vectors.

use super::{Conductor, Reflectance, colored_reflectance, multiscatter_gain};
use crate::{
    bsdf::{
        Bsdf,
        albedo::AlbedoBlock,
        block::{BsdfBlock, EvalBlock, SampleBlock, or_black},
        fresnel::{conductor, reflect},
    },
    math::{
        Sample2D, Vec3,
        block::{Each, LANES, get, get_rgb, set, set_rgb},
    },
};

/// Conductors, number by number.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct ConductorBlock {
    wo: [Each; 3],
    facets: AlbedoBlock,
    /// The tint, and the tinted reflectance at normal incidence.
    tint: [Each; 3],
    normal: [Each; 3],
    /// The dip of coloured metals.
    dip: [Each; 3],
    /// The complex index of refraction of measured ones.
    eta: [Each; 3],
    k: [Each; 3],
    /// Whether any was measured, and not 0 for those that were.
    any_measured: bool,
    is_measured: Each<u32>,
    gain: [Each; 3],
}

impl ConductorBlock {
    /// The reflectances at a cosine each.
    #[inline(always)]
    fn reflectances(&self, cos: &Each) -> [Each; 3] {
        let mut found = [[0.0; LANES]; 3];
        for (lane, cos) in cos.iter().enumerate() {
            let reflected = colored_reflectance(get_rgb(&self.normal, lane), get_rgb(&self.dip, lane), *cos);
            set_rgb(&mut found, lane, reflected);
        }
        if !self.any_measured {
            return found;
        }
        let mut measured = [[0.0; LANES]; 3];
        for k in 0..3 {
            for lane in 0..LANES {
                let reflected = conductor(cos[lane], self.eta[k][lane], self.k[k][lane]);
                measured[k][lane] = if self.is_measured[lane] != 0 {
                    reflected
                } else {
                    found[k][lane]
                };
            }
        }
        measured
    }

    /// The cosines of the facets that mirror `wi`, their densities and their masking, which are 0 where there is none.
    #[inline(always)]
    fn mirror_facets(&self, wi: &[Each; 3]) -> [Each; 3] {
        let (mut cosines, mut pdfs, mut masking) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let wi = get(wi, lane);
            let (facet, is_there) = self.facets.facets(lane).mirror_facet(get(&self.wo, lane), wi);
            let is_there = is_there & (wi.z > 0.0);
            cosines[lane] = facet.cos;
            pdfs[lane] = if is_there { facet.pdf } else { 0.0 };
            masking[lane] = if is_there { facet.masking } else { 0.0 };
        }
        [cosines, pdfs, masking]
    }
}

impl BsdfBlock for ConductorBlock {
    type Kind = Conductor;

    const EMPTY: Self = Self {
        wo: [[0.0; LANES]; 3],
        facets: AlbedoBlock::EMPTY,
        tint: [[1.0; LANES]; 3],
        normal: [[0.0; LANES]; 3],
        dip: [[0.0; LANES]; 3],
        eta: [[1.0; LANES]; 3],
        k: [[0.0; LANES]; 3],
        any_measured: false,
        is_measured: [0; LANES],
        gain: [[0.0; LANES]; 3],
    };

    fn kind(bsdf: &Bsdf) -> Option<&Conductor> {
        match bsdf {
            Bsdf::Conductor(conductor) => Some(conductor),
            _ => None,
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, bsdf: &Conductor) -> bool {
        let lane = lane % LANES;
        if !self.facets.set(lane, bsdf.albedo, &bsdf.facets) {
            return false;
        }
        set_rgb(&mut self.tint, lane, bsdf.tint);
        set_rgb(&mut self.normal, lane, bsdf.normal);
        match bsdf.reflectance {
            Reflectance::Colored { dip, .. } => {
                set_rgb(&mut self.dip, lane, dip);
                self.is_measured[lane] = 0;
            }
            Reflectance::Measured { eta, k } => {
                set_rgb(&mut self.eta, lane, eta);
                set_rgb(&mut self.k, lane, k);
                self.is_measured[lane] = 1;
            }
        }
        true
    }

    #[inline(always)]
    fn set_view(&mut self, lane: usize, wo: Vec3) {
        set(&mut self.wo, lane % LANES, wo);
    }

    #[inline(always)]
    fn prepare(&mut self) {
        self.any_measured = self.is_measured != [0; LANES];
        let all = self.facets.mirrors(&self.wo);
        let mut gains = [[0.0; LANES]; 3];
        for (lane, all) in all.iter().enumerate() {
            let gain = multiscatter_gain(get_rgb(&self.normal, lane), *all) * get_rgb(&self.tint, lane);
            set_rgb(&mut gains, lane, gain);
        }
        self.gain = gains;
    }

    #[inline(always)]
    fn eval(&self, wi: &[Each; 3]) -> EvalBlock {
        let [cos, pdf, masking] = self.mirror_facets(wi);
        let reflectance = self.reflectances(&cos);
        let mut out = EvalBlock::EMPTY;
        for lane in 0..LANES {
            let shape = pdf[lane] * masking[lane];
            let glossy = get_rgb(&reflectance, lane) * get_rgb(&self.gain, lane) * shape;
            set_rgb(&mut out.glossy, lane, or_black(pdf[lane] > 0.0, glossy));
        }
        out.pdf = pdf;
        out
    }

    #[inline(always)]
    fn sample(&self, _choices: &Each, samples: &Each<Sample2D>) -> SampleBlock {
        let mut out = SampleBlock::EMPTY;
        let mut directions = [[0.0; LANES]; 3];
        for (lane, sample) in samples.iter().enumerate() {
            let o = get(&self.wo, lane);
            let h = self.facets.facets(lane).visible_normal(o, sample.square);
            set(&mut directions, lane, reflect(o, h).normalize());
        }
        let [cos, pdf, masking] = self.mirror_facets(&directions);
        let reflectance = self.reflectances(&cos);
        for lane in 0..LANES {
            let weight = get_rgb(&reflectance, lane) * get_rgb(&self.gain, lane) * masking[lane];
            let is_black = (weight.r == 0.0) & (weight.g == 0.0) & (weight.b == 0.0);
            set_rgb(&mut out.weight, lane, weight);
            out.pdf[lane] = if is_black { 0.0 } else { pdf[lane] };
        }
        out.wi = directions;
        out
    }
}
