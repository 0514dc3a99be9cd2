//! White surfaces in a white surrounding: no more light leaves than arrives, and hardly less.
//!
//! The albedo is estimated by sampling, with numbers that are even in three dimensions and shifted
//! by chance, a few times over: so the estimate knows its own standard error, and what is asked of
//! the surface is asked within four of them.

use super::{
    super::{
        conductor::{Conductor, Reflectance},
        layered::{Boundary, Layers},
        microfacet::Ggx,
        thin_film::ThinFilm,
    },
    *,
};

/// A mean and its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    pub mean: f64,
    pub error: f64,
}

/// The largest part of a colour of the light of a white surrounding that leaves towards `wo`, of so
/// many samples.
pub fn albedo_of(bsdf: &Bsdf, wo: Vec3, samples: u32) -> Estimate {
    // Additive recurrence with the roots of x^4 = x + 1.
    let step = [
        0.819_172_513_396_164_4_f64,
        0.671_043_606_703_789_2,
        0.549_700_477_901_970_3,
    ];
    const SHIFTS: u32 = 16;
    let count = samples / SHIFTS;
    let means: Vec<[f64; 3]> = (0..SHIFTS)
        .map(|shift| {
            let start = hash::pcg4d([shift, 7, 1, 99]).map(|v| f64::from(v) / f64::from(u32::MAX));
            let mut sum = [0.0; 3];
            for i in 0..count {
                let at = |k: usize| ((start[k] + f64::from(i) * step[k]).fract() as f32).min(1.0 - f32::EPSILON);
                if let Some(sample) = bsdf.sample(wo, at(0), Vec2::new(at(1), at(2)).into()) {
                    for (sum, w) in sum.iter_mut().zip(sample.weight.to_array()) {
                        *sum += f64::from(w) / f64::from(count);
                    }
                }
            }
            sum
        })
        .collect();
    let estimate = |k: usize| {
        let n = f64::from(SHIFTS);
        let mean = means.iter().map(|m| m[k]).sum::<f64>() / n;
        let variance = means.iter().map(|m| (m[k] - mean) * (m[k] - mean)).sum::<f64>() / (n - 1.0);
        Estimate {
            mean,
            error: (variance / n).sqrt(),
        }
    };
    [1, 2]
        .map(estimate)
        .into_iter()
        .fold(estimate(0), |a, b| if b.mean > a.mean { b } else { a })
}

/// In standard errors.
const SIGMAS: f64 = 4.0;
/// The error of summing numbers of 24 bits in sampling.
const ROUNDING: f64 = 2e-5;

/// An estimate is not made better than this, nor of more samples.
const SMALLEST_ERROR: f64 = 5e-4;
const MAX_SAMPLES: u32 = 1 << 15;

/// Returns the estimate if the albedo of a white surface is wrong; at least `least` of the light must leave.
fn wrong(bsdf: &Bsdf, wo: Vec3, least: f64) -> Option<Estimate> {
    let mut samples = 1 << 9;
    loop {
        let all = albedo_of(bsdf, wo, samples);
        let slack = SIGMAS * all.error + ROUNDING;
        let (low, high) = (all.mean < least - slack, all.mean > 1.0 + slack);
        // Sure that it is right, or so exact that it matters no more.
        let right = all.mean - slack > least && all.mean + slack < 1.0;
        if right || all.error < SMALLEST_ERROR || samples >= MAX_SAMPLES {
            return (low || high).then_some(all);
        }
        samples *= 4;
    }
}

const COSINES: [f32; 6] = [1.0, 0.8, 0.4, 0.1, 0.03, 0.004];

/// Checks `bsdf` from all angles, at several turns where it is brushed.
fn check(name: &str, bsdf: &Bsdf, least: f64, all_wrong: &mut Vec<String>) {
    let turns: &[f32] = if bsdf.reads_tangent() { &[0.0, 0.8, 1.5] } else { &[0.7] };
    let sides: &[f32] = if bsdf.transmits() { &[1.0, -1.0] } else { &[1.0] };
    for cos in COSINES {
        for side in sides {
            for turn in turns {
                let cos = cos * side;
                if let Some(all) = wrong(bsdf, direction(cos, *turn), least) {
                    all_wrong.push(format!("{name} from {cos} {turn}: {:.4} +- {:.4}", all.mean, all.error));
                }
            }
        }
    }
}

fn nothing(all_wrong: &[String]) {
    assert!(all_wrong.is_empty(), "{}\n{}", all_wrong.len(), all_wrong.join("\n"));
}

#[test]
fn white_surfaces_lose_less_than_two_percent_and_gain_nothing_at_any_angle() {
    let mut all_wrong = Vec::new();
    for Example { name, bsdf, .. } in white_examples() {
        check(&name, &bsdf, 0.98, &mut all_wrong);
    }
    nothing(&all_wrong);
}

#[test]
fn white_metals_of_any_roughness_and_anisotropy_lose_less_than_two_percent_and_gain_nothing() {
    let mut all_wrong = Vec::new();
    let reflectance = Reflectance::colored(Rgb::WHITE, Rgb::WHITE);
    for roughness in [0.0, 0.033, 0.1, 0.22, 0.37, 0.5, 0.63, 0.81, 0.95, 1.0] {
        for anisotropy in [0.0, 0.1, 0.3, 0.45, 0.6, 0.75, 0.9, 1.0] {
            let facets = Ggx::from_roughness(roughness, anisotropy);
            let metal = Bsdf::Conductor(Conductor::new(facets, reflectance));
            check(&format!("{roughness} {anisotropy}"), &metal, 0.98, &mut all_wrong);
        }
    }
    nothing(&all_wrong);
}

/// A surface whose every key is drawn anew.
fn drawn(i: u32) -> Layers {
    let number = |k: u32| hash::pcg4d([i, k, 3, 11]).map(|v| (v >> 8) as f32 / (1 << 24) as f32)[0];
    let one_of = |k: u32, all: &[f32]| all[(number(k) * all.len() as f32) as usize];
    // Half of the time one of the extremes.
    let part = |k: u32| {
        if number(k) < 0.5 {
            one_of(k + 100, &[0.0, 0.0, 1.0])
        } else {
            number(k + 200)
        }
    };
    let transmission = part(0);
    let boundary = if number(1) < 0.5 {
        Boundary::ThinWalled
    } else {
        Boundary::Solid
    };
    let facets = Ggx::from_roughness(part(2), part(3));
    Layers {
        base_color: Rgb::WHITE,
        metallic: one_of(4, &[0.0, 0.0, 0.5, 1.0]),
        transmission,
        diffuse_transmission: part(14),
        diffuse_transmission_color: Rgb::WHITE,
        facets: if boundary == Boundary::Solid && transmission > 0.0 {
            facets.isotropic()
        } else {
            facets
        },
        rotation: Vec2::X,
        ior: one_of(5, &[1.1, 1.33, 1.5, 1.8, 2.4, 0.8, 3.5]),
        dispersion: 0.0,
        hero: None,
        boundary,
        specular: 1.0 - part(6),
        specular_color: Rgb::WHITE,
        thin_film: ThinFilm {
            weight: part(7),
            ior: 1.3 + 0.4 * number(8),
            thickness: 700e-9 * number(9),
            ..ThinFilm::NONE
        },
        coat: part(10),
        coat_facets: Ggx::from_roughness(part(11), 0.0),
        coat_normal: Vec3::Z,
        sheen: Rgb::gray(part(12)),
        sheen_roughness: part(13),
    }
}

#[test]
fn principled_surfaces_of_any_keys_lose_less_than_two_percent_and_gain_nothing() {
    let mut all_wrong = Vec::new();
    for i in 0..RANDOM_SURFACES {
        let layered = drawn(i);
        check(&format!("{i} {layered:?}"), &layered.into(), 0.98, &mut all_wrong);
    }
    nothing(&all_wrong);
}

/// The number of random surfaces.
const RANDOM_SURFACES: u32 = 40;

#[test]
fn the_furnace_finds_what_gains_or_loses_a_percent_too_much() {
    let lambert = |albedo: f32| {
        Bsdf::Lambert(super::super::diffuse::Lambert {
            albedo: Rgb::gray(albedo),
        })
    };
    let found = |albedo: f32| wrong(&lambert(albedo), direction(0.5, 0.0), 0.98).is_some();
    assert!(found(1.01) && found(0.97) && !found(0.985) && !found(1.0));
}
