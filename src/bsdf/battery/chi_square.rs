//! Samples fall where the density says.

use std::f64::consts::TAU;

use super::{
    super::{BsdfKind, diffuse::Lambert},
    *,
};

/// Bins by tilt and by turn.
const TILTS: usize = 12;
const TURNS: usize = 8;
/// Bins that expect fewer samples are put together.
const MIN_EXPECTED: f64 = 8.0;
/// In standard deviations: a chance of 3e-6.
const LIMIT: f64 = 4.5;

fn bin(w: Vec3) -> usize {
    let (across, up) = (f64::from(w.x).hypot(f64::from(w.y)), f64::from(w.z));
    let tilt = (libm::atan2(across, up) / (0.5 * TAU) * TILTS as f64) as usize;
    let turn = (libm::atan2(f64::from(w.y), f64::from(w.x)) / TAU).rem_euclid(1.0);
    tilt.min(TILTS - 1) * TURNS + ((turn * TURNS as f64) as usize).min(TURNS - 1)
}

/// The integral of `pdf` over each bin, by so many points along each side of a bin.
fn expected(points: usize, pdf: impl Fn(Vec3) -> f32) -> Vec<f64> {
    let (tilts, turns) = (TILTS * points, TURNS * points);
    let mut all = vec![0.0; TILTS * TURNS];
    for i in 0..tilts {
        let tilt = 0.5 * TAU * (i as f64 + 0.5) / tilts as f64;
        let area = libm::sin(tilt) * 0.5 * TAU * TAU / (tilts * turns) as f64;
        for j in 0..turns {
            let turn = TAU as f32 * (j as f32 + 0.5) / turns as f32;
            let w = direction(libm::cos(tilt) as f32, turn);
            all[i / points * TURNS + j / points] += f64::from(pdf(w)) * area;
        }
    }
    all
}

/// The difference between the counts of `count` samples and the expectation of `pdf`, in standard
/// deviations. Directions that are not sampled have a bin of their own.
fn deviation(
    name: &str,
    [count, points]: [u32; 2],
    sample: impl Fn(u32) -> Option<Vec3>,
    pdf: impl Fn(Vec3) -> f32,
) -> f64 {
    let expected = expected(points as usize, pdf);
    let sampled: f64 = expected.iter().sum();
    assert!(sampled < 1.02, "{name}: the density integrates to {sampled}");
    let mut found = vec![0_u32; TILTS * TURNS + 1];
    for i in 0..count {
        found[sample(i).map_or(TILTS * TURNS, bin)] += 1;
    }
    let mut rest = (0.0, 0.0);
    let (mut sum, mut bins) = (0.0, 0.0);
    let mut count_bin = |expected: f64, found: f64| {
        sum += (found - expected) * (found - expected) / expected;
        bins += 1.0;
    };
    let lost = (1.0 - sampled).max(0.0);
    for (expected, found) in expected.into_iter().chain([lost]).zip(found) {
        let (expected, found) = (expected * f64::from(count), f64::from(found));
        if expected >= MIN_EXPECTED {
            count_bin(expected, found);
        } else {
            rest = (rest.0 + expected, rest.1 + found);
        }
    }
    if rest.0 >= MIN_EXPECTED || rest.1 >= 3.0 * MIN_EXPECTED {
        count_bin(rest.0.max(1.0), rest.1);
    }
    if bins < 2.0 {
        return 0.0;
    }
    // The cube root of chi square is nearly normal (Wilson and Hilferty 1931).
    let spread = 2.0 / (9.0 * (bins - 1.0));
    (libm::cbrt(sum / (bins - 1.0)) - (1.0 - spread)) / spread.sqrt()
}

#[test]
fn samples_fall_where_the_density_says() {
    let mut wrong = Vec::new();
    for Example { name, bsdf, width } in examples() {
        // Narrower lobes are beyond the integral's reach; they are of the same formulas.
        if bsdf.is_delta() || (width > 0.0 && width < 0.5) {
            continue;
        }
        // The ones of full roughness are alike.
        let views = if width == 1.0 { 1 } else { 3 };
        let back = if bsdf.transmits() { -0.5 } else { 0.4 };
        for wo in [0.35, back, 0.8].into_iter().take(views).map(|cos| direction(cos, 0.4)) {
            let sample = |i| {
                let (uc, u) = numbers(i);
                bsdf.sample(wo, uc, u.into()).filter(|s| s.pdf.is_some()).map(|s| s.wi)
            };
            // What passes rough glass ends abruptly at the horizon.
            let points = if bsdf.transmits() { 14 } else { 8 };
            let points = if bsdf.transmits() && width == 1.0 { 40 } else { points };
            let off = deviation(&format!("{name} from {wo}"), [4000, points], sample, |wi| {
                bsdf.eval(wo, wi).pdf
            });
            if off > LIMIT {
                wrong.push(format!("{name} from {wo}: {off}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_bias_of_one_percent_is_found_and_none_is_not() {
    let lambert = Lambert { albedo: Rgb::WHITE };
    let wo = direction(0.7, 0.0);
    let sample = |i| {
        let (uc, u) = numbers(i);
        lambert.sample(wo, uc, u.into()).map(|s| s.wi)
    };
    let biased = |wi: Vec3| lambert.eval(wo, wi).pdf * if wi.x > 0.0 { 1.01 } else { 0.99 };
    assert!(deviation("lambert", [1_000_000, 10], sample, |wi| lambert.eval(wo, wi).pdf) < LIMIT);
    assert!(deviation("lambert", [1_000_000, 10], sample, biased) > LIMIT);
}
