//! The requirements on every BSDF, tested on examples of all of them.

use super::{Bsdf, BsdfEval, BsdfKind, BsdfSample, Lobe};
use crate::math::{Rgb, Vec2, Vec3, hash};

mod blocks;
mod chi_square;
mod energy;
mod examples;
mod furnace;
mod reciprocity;

use examples::{Example, examples, white_examples};

/// A unit direction of the cosine `cos`, which is below the surface where it is negative.
fn direction(cos: f32, turn: f32) -> Vec3 {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    Vec3::new(sin * libm::cosf(turn), sin * libm::sinf(turn), cos)
}

/// The `i`th of three numbers that are uniform in `[0, 1)`.
fn numbers(i: u32) -> (f32, Vec2) {
    let [a, b, c, _] = hash::pcg4d([i, 17, 23, 5]).map(|v| (v >> 8) as f32 / (1 << 24) as f32);
    (a, Vec2::new(b, c))
}

/// Directions to look from: all on the front where nothing passes.
fn views(bsdf: &Bsdf) -> Vec<Vec3> {
    let mut all = vec![
        direction(1.0, 0.0),
        direction(0.7, 0.4),
        direction(0.25, 2.0),
        direction(0.1, -1.0),
    ];
    if bsdf.transmits() {
        all.extend([direction(-0.8, 1.0), direction(-0.3, 2.5)]);
    }
    all
}

fn close(a: Rgb, b: Rgb, tolerance: f32) -> bool {
    let scale = a.max_component().max(b.max_component()).max(1e-6);
    (a - b).map(f32::abs).max_component() <= tolerance * scale
}

#[test]
fn every_kind_has_an_example() {
    let texts: Vec<_> = examples().iter().map(|e| format!("{:?}", e.bsdf)).collect();
    for name in Bsdf::NAMES {
        let is_shown = texts.iter().any(|text| text.starts_with(&format!("{name}(")));
        assert!(is_shown, "src/bsdf/battery/examples.rs has no example of `{name}`");
    }
}

#[test]
fn a_sample_weighs_what_eval_says_over_its_density() {
    for Example { name, bsdf, .. } in examples() {
        for wo in views(&bsdf) {
            let mut taken = 0;
            for i in 0..600 {
                let (uc, u) = numbers(i);
                let Some(sample) = bsdf.sample(wo, uc, u.into()) else {
                    continue;
                };
                taken += 1;
                check_sample(&name, &bsdf, wo, &sample);
            }
            assert!(taken > 100, "{name}: {taken} of 600 samples from {wo}");
        }
    }
}

fn check_sample(name: &str, bsdf: &Bsdf, wo: Vec3, sample: &BsdfSample) {
    let BsdfSample { wi, weight, .. } = *sample;
    assert!((wi.length() - 1.0).abs() < 1e-5, "{name}: {wi}");
    assert!(
        weight.is_finite() && weight.r >= 0.0 && weight.g >= 0.0 && weight.b >= 0.0,
        "{name}: {weight:?}"
    );
    let passes = wi.z * wo.z < 0.0;
    // A tilted coat may mirror light below the plane of the normal, which does not go through the surface.
    let passes = passes && bsdf.transmits();
    assert_eq!(passes, sample.lobe == Lobe::Transmission, "{name}: {wo} {wi}");
    assert!(passes || sample.eta == 1.0, "{name}");
    let eval = bsdf.eval(wo, wi);
    let Some(pdf) = sample.pdf else {
        assert!(sample.diffuse.is_black(), "{name}: a delta lobe is not diffuse");
        return;
    };
    assert!(
        pdf > 0.0 && (eval.pdf / pdf - 1.0).abs() < 2e-3,
        "{name}: {wo} {wi}: {} {pdf}",
        eval.pdf
    );
    assert!(
        close(eval.f_cos() / pdf, weight, 3e-3),
        "{name}: {wo} {wi}: {:?} {weight:?}",
        eval.f_cos() / pdf
    );
    assert!(close(eval.diffuse / pdf, sample.diffuse, 3e-3), "{name}");
}

#[test]
fn delta_lobes_are_zero_in_eval() {
    for Example { name, bsdf, .. } in examples().into_iter().filter(|e| e.bsdf.is_delta()) {
        for wo in views(&bsdf) {
            for i in 0..50 {
                let (uc, u) = numbers(i);
                let Some(sample) = bsdf.sample(wo, uc, u.into()) else {
                    continue;
                };
                assert_eq!(sample.pdf, None, "{name}");
                assert_eq!(bsdf.eval(wo, sample.wi), BsdfEval::default(), "{name}");
            }
        }
    }
}

#[test]
fn light_in_the_plane_of_the_surface_does_no_harm() {
    for Example { name, bsdf, .. } in examples() {
        for wo in [direction(0.0, 0.3), direction(1e-6, 0.0), direction(-1e-6, 0.0)] {
            for i in 0..20 {
                let (uc, u) = numbers(i);
                if let Some(sample) = bsdf.sample(wo, uc, u.into()) {
                    assert!(sample.weight.is_finite() && sample.wi.is_finite(), "{name}: {sample:?}");
                }
            }
            for cos in [0.0, 1e-6, 0.5, -0.5, -1e-6] {
                let eval = bsdf.eval(wo, direction(cos, 2.0));
                assert!(eval.f_cos().is_finite() && eval.pdf.is_finite(), "{name}: {eval:?}");
            }
        }
    }
}

#[test]
fn a_bsdf_is_small() {
    let bytes = size_of::<Bsdf>();
    assert!(bytes <= 160, "{bytes}");
}
