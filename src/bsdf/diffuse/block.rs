//! Rough diffuse surfaces on vectors.

use super::OrenNayar;
use crate::{
    bsdf::{
        Bsdf,
        block::{BsdfBlock, EvalBlock, SampleBlock, or_black},
    },
    math::{
        Rgb, Sample2D, Vec3,
        block::{Each, LANES, get, get_rgb, set, set_rgb},
        warp,
    },
};

/// Rough diffuse surfaces, number by number.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct OrenNayarBlock {
    wo: [Each; 3],
    albedo: [Each; 3],
    roughness: Each,
}

impl BsdfBlock for OrenNayarBlock {
    type Kind = OrenNayar;

    const EMPTY: Self = Self {
        wo: [[0.0; LANES]; 3],
        albedo: [[0.0; LANES]; 3],
        roughness: [0.0; LANES],
    };

    fn kind(bsdf: &Bsdf) -> Option<&OrenNayar> {
        match bsdf {
            Bsdf::OrenNayar(oren_nayar) => Some(oren_nayar),
            _ => None,
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, bsdf: &OrenNayar) -> bool {
        let lane = lane % LANES;
        set_rgb(&mut self.albedo, lane, bsdf.albedo);
        self.roughness[lane] = bsdf.roughness;
        !bsdf.albedo.is_black()
    }

    #[inline(always)]
    fn set_view(&mut self, lane: usize, wo: Vec3) {
        set(&mut self.wo, lane % LANES, wo);
    }

    #[inline(always)]
    fn prepare(&mut self) {}

    #[inline(always)]
    fn eval(&self, wi: &[Each; 3]) -> EvalBlock {
        let mut out = EvalBlock::EMPTY;
        for lane in 0..LANES {
            let bsdf = OrenNayar {
                albedo: get_rgb(&self.albedo, lane),
                roughness: self.roughness[lane],
            };
            let wi = get(wi, lane);
            let is_lit = wi.z > 0.0;
            let f_cos: Rgb = bsdf.f_cos(get(&self.wo, lane), wi);
            set_rgb(&mut out.diffuse, lane, or_black(is_lit, f_cos));
            out.pdf[lane] = warp::cosine_hemisphere_pdf(wi.z);
        }
        out
    }

    #[inline(always)]
    fn sample(&self, _choices: &Each, samples: &Each<Sample2D>) -> SampleBlock {
        let mut directions = [[0.0; LANES]; 3];
        for (lane, sample) in samples.iter().enumerate() {
            set(&mut directions, lane, sample.cosine_hemisphere());
        }
        let eval = self.eval(&directions);
        let mut out = SampleBlock::EMPTY;
        for lane in 0..LANES {
            set_rgb(&mut out.weight, lane, get_rgb(&eval.diffuse, lane) / eval.pdf[lane]);
        }
        (out.wi, out.pdf, out.diffuse) = (directions, eval.pdf, out.weight);
        out.is_diffuse = [1; LANES];
        out
    }
}
