//! Nothing is gained, and white loses nothing.

use super::{
    super::{
        Bsdf, Lobe,
        albedo::{self, FacetAlbedo},
        conductor::{Conductor, Reflectance},
        fresnel,
        microfacet::{Facets, Ggx},
    },
    *,
};

/// The part of the light of a white surrounding that leaves towards `wo`, and the part of it that
/// passed.
fn albedo_of(bsdf: &Bsdf, wo: Vec3, count: u32) -> (Rgb, Rgb) {
    // Additive recurrence with the roots of x^4 = x + 1: even in three dimensions, so few points
    // will do.
    let step = [0.819_172_5_f64, 0.671_043_6, 0.549_700_5];
    let (mut all, mut passed) = ([0.0_f64; 3], [0.0_f64; 3]);
    for i in 0..count {
        let [a, b, c] = step.map(|s| ((f64::from(i) + 0.5) * s).fract() as f32);
        if let Some(sample) = bsdf.sample(wo, a, Vec2::new(b, c).into()) {
            for (k, w) in sample.weight.to_array().into_iter().enumerate() {
                all[k] += f64::from(w);
                if sample.lobe == Lobe::Transmission {
                    passed[k] += f64::from(w);
                }
            }
        }
    }
    let mean = |sum: [f64; 3]| Rgb::from_array(sum.map(|s| (s / f64::from(count)) as f32));
    (mean(all), mean(passed))
}

#[test]
fn no_surface_sends_back_more_than_arrives() {
    for Example { name, bsdf, .. } in examples() {
        for wo in views(&bsdf) {
            let all = albedo_of(&bsdf, wo, 400).0;
            assert!(all.max_component() < 1.02, "{name} from {wo}: {all:?}");
        }
    }
}

/// The mean of `f` over facets that are seen from `wo`; there are `points` of them along each axis.
fn mean_over_facets(ggx: &Ggx, wo: Vec3, points: u32, f: impl Fn(Vec3) -> [f32; 4]) -> [f32; 4] {
    let mut sum = [0.0_f64; 4];
    for i in 0..points * points {
        let q = ((i / points) as f32 + 0.5) / points as f32;
        let u = Vec2::new(((i % points) as f32 + 0.5) / points as f32, 1.0 - q * q);
        for (sum, v) in sum.iter_mut().zip(f(ggx.sample_normal(wo, u))) {
            *sum += f64::from(v * 2.0 * q);
        }
    }
    sum.map(|s| (s / f64::from(points * points)) as f32)
}

fn masking(facet: Option<super::super::microfacet::Facet>) -> f32 {
    facet.map_or(0.0, |f| f.masking)
}

#[test]
fn the_tables_say_no_less_than_the_truth_and_little_more() {
    let mut wrong = Vec::new();
    for roughness in [0.033, 0.045, 0.12, 0.33, 0.47, 0.61, 0.76, 0.88, 1.0] {
        let ggx = Ggx::from_roughness(roughness, 0.0);
        let of_facets = FacetAlbedo::new(&ggx);
        for cos in [0.002, 0.02, 0.06, 0.13, 0.25, 0.4, 0.62, 0.77, 0.92, 1.0] {
            let wo = direction(cos, 0.0);
            for eta in [1.1, 1.45, 1.6, 2.7, 1.0 / 1.1, 0.69, 0.4] {
                let [all, grazing, fresnel, passing] = mean_over_facets(&ggx, wo, 160, |h| {
                    let mirrored = masking(ggx.reflection(wo, fresnel::reflect(wo, h)));
                    let passed = fresnel::refract(wo, h, eta).map(|wi| masking(ggx.transmission(wo, wi, eta)));
                    let reflected = fresnel::dielectric(wo.dot(h), eta);
                    [
                        mirrored,
                        mirrored * fresnel::schlick_term(wo.dot(h)),
                        reflected * mirrored + (1.0 - reflected) * passed.unwrap_or(0.0),
                        passed.unwrap_or(mirrored),
                    ]
                });
                let schlick = of_facets.schlick(&ggx, wo);
                let clear = albedo::clear(&ggx, wo, eta);
                for (what, is, said, most) in [
                    ("mirrors", all, of_facets.mirrors(&ggx, wo), 0.004),
                    ("grazing", grazing, schlick[1], 0.008),
                    ("fresnel", fresnel, clear.fresnel, 0.01),
                    ("passing", passing, clear.passing, 0.01),
                ] {
                    if !(-2e-4..most).contains(&(said - is)) {
                        wrong.push(format!("{what} {roughness} {cos} {eta}: {is} {said} {}", said - is));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn the_tables_of_brushed_facets_say_no_less_than_the_truth_and_little_more() {
    let mut wrong = Vec::new();
    for (roughness, anisotropy) in [
        (0.0, 1.0),
        (0.0, 0.5),
        (0.1, 0.3),
        (0.15, 0.9),
        (0.3, 0.6),
        (0.5, 0.8),
        (0.7, 0.4),
    ] {
        let ggx = Ggx::from_roughness(roughness, anisotropy);
        let of_facets = FacetAlbedo::new(&ggx);
        for cos in [0.002, 0.01, 0.05, 0.13, 0.3, 0.6, 0.85, 1.0] {
            for turn in [0.0, 0.4, 0.9, 1.2, 1.4, 1.5, 1.57] {
                let wo = direction(cos, turn);
                let [all, grazing, ..] = mean_over_facets(&ggx, wo, 160, |h| {
                    let mirrored = masking(ggx.reflection(wo, fresnel::reflect(wo, h)));
                    [mirrored, mirrored * fresnel::schlick_term(wo.dot(h)), 0.0, 0.0]
                });
                let [a, b] = of_facets.schlick(&ggx, wo);
                for (what, is, said, most) in [("mirrors", all, a + b, 0.01), ("grazing", grazing, b, 0.025)] {
                    if !(-2e-4..most).contains(&(said - is)) {
                        wrong.push(format!(
                            "{what} {roughness} {anisotropy} {cos} {turn}: {is} {said} {}",
                            said - is
                        ));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn facets_that_become_smooth_become_a_mirror_and_glass() {
    let roughness = 0.034;
    let ggx = Ggx::from_roughness(roughness, 0.0);
    for cos in [1.0, 0.6, 0.2] {
        let wo = direction(cos, 1.0);
        let reflectance = Reflectance::Measured {
            eta: Rgb::new(0.21, 0.43, 1.38),
            k: Rgb::new(3.272, 2.455, 1.914),
        };
        let metal = Bsdf::Conductor(Conductor::new(ggx, reflectance));
        let all = albedo_of(&metal, wo, 500).0;
        assert!(close(all, reflectance.at(cos), 3e-3), "{all:?}");
        let rough = examples::glass(roughness, 1.5, Rgb::WHITE, Rgb::WHITE);
        let smooth = examples::glass(0.0, 1.5, Rgb::WHITE, Rgb::WHITE);
        for wo in [wo, -wo] {
            let (a, b) = (albedo_of(&rough, wo, 4000).1, albedo_of(&smooth, wo, 4000).1);
            assert!((a - b).map(f32::abs).max_component() < 4e-3, "{wo}: {a:?} {b:?}");
        }
        let along = metal.sample(wo, 0.5, Vec2::splat(0.5).into()).unwrap().wi;
        assert!((along - Vec3::new(-wo.x, -wo.y, wo.z)).length() < 0.01);
    }
}

#[test]
fn a_colored_metal_reflects_its_colour_and_its_edge() {
    let (color, edge) = (Rgb::new(0.9, 0.5, 0.1), Rgb::new(1.0, 0.8, 0.5));
    let metal = Reflectance::colored(color, edge);
    assert!(close(metal.at(1.0), color, 1e-6) && close(metal.at(0.0), Rgb::WHITE, 1e-6));
    let plain = Reflectance::colored(color, Rgb::WHITE);
    assert!(close(metal.at(1.0 / 7.0), plain.at(1.0 / 7.0) * edge, 1e-5));
}

#[test]
fn a_film_without_thickness_is_not_there() {
    use super::super::thin_film::ThinFilm;
    let thin_film = ThinFilm {
        weight: 1.0,
        ior: 1.3,
        thickness: 0.0,
        ..ThinFilm::NONE
    };
    for (f0, cos) in [(0.04, 1.0), (0.3, 0.5), (0.9, 0.2)] {
        let bare = f0 + (1.0 - f0) * fresnel::schlick_term(cos);
        let all = thin_film.reflectance(Rgb::gray(f0), cos);
        assert!(
            (all - Rgb::gray(bare)).map(f32::abs).max_component() < 0.02,
            "{all:?} {bare}"
        );
    }
    let colors =
        [250e-9, 400e-9, 550e-9].map(|thickness| ThinFilm { thickness, ..thin_film }.reflectance(Rgb::gray(0.04), 0.9));
    assert!(colors.iter().all(|c| (c.r - c.b).abs() > 0.003), "{colors:?}");
}
