//! Lights with the distribution of a file: their irradiance, and what rays find of them.

use crate::{
    light::{
        Light, LightDesc, LightFind, LightTables, Profile, ProfileId,
        profile::{Measurement, Photometry, Symmetry},
    },
    math::{DVec3, Ray, Vec2, Vec3, hash::mix32, hash::unit_f32},
};

/// A profile of type C with this intensity in W sr^-1 at the vertical and the horizontal angle in degrees.
fn profile(intensity: impl Fn(f32, f32) -> f32) -> Profile {
    let vertical: Vec<f32> = (0..=180).map(|v| v as f32).collect();
    let horizontal: Vec<f32> = (0..=72).map(|h| h as f32 * 5.0).collect();
    let candela = |h: &f32| vertical.iter().map(|v| 683.0 * intensity(*v, *h)).collect::<Vec<_>>();
    Profile::new(&Measurement {
        photometry: Photometry::C,
        candela: horizontal.iter().flat_map(candela).collect(),
        vertical: vertical.clone(),
        horizontal: horizontal.clone(),
        symmetry: Symmetry::None,
    })
}

fn cosine(degrees: f32) -> f32 {
    libm::cosf(degrees.to_radians())
}

fn light(text: &str) -> Light {
    let desc: LightDesc = toml::from_str(text).expect("a light");
    let find = LightFind {
        profile: &|_| Ok(ProfileId(0)),
        ..LightFind::nothing(DVec3::ZERO)
    };
    desc.compile(&find).expect("a valid light")
}

fn number(i: u32) -> f32 {
    unit_f32(mix32(i))
}

/// The irradiance on a surface that faces the light, at `from`.
fn irradiance(light: &Light, profile: &Profile, from: Vec3) -> f32 {
    let tables = LightTables {
        profiles: std::slice::from_ref(profile),
        ..LightTables::NONE
    };
    let n = if light.has_size() { 4096 } else { 1 };
    let samples = (0..n).filter_map(|i| {
        let u = Vec2::new((i as f32 + 0.5) / n as f32, number(i));
        let sample = light.sample(&tables, from, u)?;
        Some(sample.li.g / sample.pdf.unwrap_or(1.0))
    });
    samples.sum::<f32>() / n as f32
}

#[test]
fn irradiance_below_and_beside_a_lamp_is_the_intensity_by_the_square_of_the_distance() {
    // Brighter towards the horizontal angle 0 than opposite to it.
    let own = |v: f32, h: f32| {
        if v < 90.0 {
            cosine(v) * cosine(v) * (3.0 + cosine(90.0 - v) * cosine(h))
        } else {
            0.0
        }
    };
    let profile = profile(own);
    let radius = 0.01;
    let lamps = [
        "point = { position = [0, 3, 0], ies = '' }".to_owned(),
        "point = { position = [0, 3, 0], ies = '', direction = [0, -1, 0], up = [0, 0, -1], radius = 0.01 }".to_owned(),
        "spot = { position = [0, 3, 0], ies = '', target = [0, 0, 0], cone_angle = 80 }".to_owned(),
        format!("disk = {{ position = [0, 3, 0], ies = '', direction = [0, -1, 0], radius = {radius} }}"),
        "rect = { position = [0, 3, 0], ies = '', direction = [0, -1, 0], size = [0.02, 0.02] }".to_owned(),
    ];
    for text in &lamps {
        let lamp = light(text);
        for (v, h) in [
            (0.0, 0.0),
            (30.0, 0.0),
            (30.0, 90.0),
            (60.0, 180.0),
            (70.0, 270.0),
            (45.0, 37.0),
        ] {
            // The lamp shines down, its angle 0 towards -z, and 90 to the left as seen along the light: towards -x.
            let [(sin_v, cos_v), (sin_h, cos_h)] = [v, h].map(|a: f32| libm::sincosf(a.to_radians()));
            let w = Vec3::new(-sin_v * sin_h, -cos_v, -sin_v * cos_h);
            for distance in [1.0_f32, 4.0] {
                let found = irradiance(&lamp, &profile, Vec3::new(0.0, 3.0, 0.0) + w * distance);
                let expected = own(v, h) / (distance * distance);
                assert!(
                    (found / expected - 1.0).abs() < 2e-3,
                    "{text} {v} {h}: {found} {expected}"
                );
            }
        }
        let above = irradiance(&lamp, &profile, Vec3::new(0.1, 4.0, 0.0));
        assert_eq!(above, 0.0, "{text}");
    }
}

#[test]
fn strengths_scale_the_file_or_replace_its_power() {
    let profile = profile(|v, _| if v <= 120.0 { 2.0 + cosine(v) } else { 0.0 });
    let below = |keys: &str| {
        let text = format!("point = {{ position = [0, 3, 0], ies = '' {keys} }}");
        irradiance(&light(&text), &profile, Vec3::new(0.0, 1.0, 0.0))
    };
    let own = below("");
    assert!((own - 0.75).abs() < 1e-5);
    assert!((below(", exposure = 1") - 2.0 * own).abs() < 1e-5);
    assert!((below(", intensity = 0.5") - 0.5 * own).abs() < 1e-5);
    assert!((below(", power = 10") - own * 10.0 / profile.power()).abs() < 1e-4);
    // A disk sends one side of the file only, and that is its power.
    let disk = |keys: &str| {
        let text = format!("disk = {{ position = [0, 3, 0], ies = '', direction = [0, -1, 0], radius = 0.01 {keys} }}");
        irradiance(&light(&text), &profile, Vec3::new(0.0, -97.0, 0.0)) * 1e4
    };
    assert!((disk("") - 3.0).abs() < 1e-2);
    assert!((disk(", power = 10") - 30.0 / profile.front_power()).abs() < 1e-2);
    assert!((disk(", power = 10, two_sided = true") - 30.0 / profile.power()).abs() < 1e-2);
}

#[test]
fn a_disk_with_a_cosine_is_a_disk_of_constant_radiance() {
    let profile = profile(|v, _| cosine(v).max(0.0));
    let keys = "position = [0, 3, 0], direction = [0.2, -1, 0], radius = 0.8";
    let area = std::f32::consts::PI * 0.64;
    let own = light(&format!("disk = {{ {keys}, ies = '' }}"));
    let plain = light(&format!("disk = {{ {keys}, radiance = {} }}", 1.0 / area));
    let tables = LightTables {
        profiles: std::slice::from_ref(&profile),
        ..LightTables::NONE
    };
    let mut lit = 0;
    for i in 0..2000 {
        let from = Vec3::new(
            number(i) * 4.0 - 2.0,
            number(i + 5000) * 2.9,
            number(i + 9000) * 4.0 - 2.0,
        );
        let u = Vec2::new(number(i + 40_000), number(i + 50_000));
        let (Some(a), Some(b)) = (own.sample(&tables, from, u), plain.sample(&tables, from, u)) else {
            continue;
        };
        // Next to the plane the disk with a file fades.
        if b.wi.dot(Vec3::new(-0.2, 1.0, 0.0).normalize()) > 0.05 {
            assert!((a.li.g / b.li.g - 1.0).abs() < 2e-3, "{from}: {} {}", a.li.g, b.li.g);
            assert_eq!((a.wi, a.pdf), (b.wi, b.pdf));
            lit += 1;
        }
    }
    assert!(lit > 1000, "{lit}");
}

#[test]
fn a_ray_along_a_sample_finds_the_light_of_the_file() {
    let profile = profile(|v, h| {
        if v < 130.0 {
            1.2 + cosine(v) + 0.1 * cosine(h)
        } else {
            0.0
        }
    });
    let tables = LightTables {
        profiles: std::slice::from_ref(&profile),
        ..LightTables::NONE
    };
    let lamps = [
        "point = { position = [0, 3, 0], ies = '', radius = 0.4 }",
        "spot = { position = [0, 3, 0], ies = '', target = [0, 0, 0.3], cone_angle = 70, radius = 0.3, power = 9 }",
        "disk = { position = [0, 3, 0], ies = '', direction = [0, -1, 0.2], radius = 0.6 }",
        "disk = { position = [0, 3, 0], ies = '', direction = [0, -1, 0.2], radius = 0.6, two_sided = true }",
        "rect = { position = [0, 3, 0], ies = '', direction = [0, -1, 0.2], size = [1, 0.4], power = [1, 2, 3] }",
    ];
    for text in lamps {
        let lamp = light(text);
        let (surface, _) = lamp.surface().expect("a surface");
        let mut found = 0;
        for i in 0..600 {
            let from = Vec3::new(number(i) - 0.5, number(i + 5000), number(i + 9000) - 0.5) * 6.0;
            let u = Vec2::new(number(i + 40_000), number(i + 50_000));
            let Some(sample) = lamp.sample(&tables, from, u) else {
                continue;
            };
            let ray = Ray::new(from, sample.wi);
            let Some(hit) = surface.intersect(&ray) else { continue };
            if surface.surface(&ray, &hit).ng.dot(sample.wi).abs() < 0.5 || (hit.t - sample.distance).abs() > 1e-3 {
                continue;
            }
            let (radiance, pdf) = lamp.seen(&tables, from, sample.wi, &hit);
            let own = sample.pdf.expect("a density");
            assert!((radiance.r / sample.li.r - 1.0).abs() < 2e-3, "{text}");
            assert!((pdf / own - 1.0).abs() < 2e-3, "{text}");
            found += 1;
        }
        assert!(found > 30, "{text}: {found}");
    }
}

#[test]
fn wrong_keys_are_refused_in_words() {
    let message = |text: &str| {
        let desc: LightDesc = toml::from_str(text).expect("a light");
        let find = LightFind {
            profile: &|_| Ok(ProfileId(0)),
            ..LightFind::nothing(DVec3::ZERO)
        };
        desc.compile(&find).expect_err("refused").message
    };
    assert_eq!(
        message("point = { position = [0, 1, 0], intensity = 1, up = [0, 1, 0] }"),
        "`up` turns the light of `ies`, which is not given"
    );
    assert_eq!(
        message("point = { position = [0, 1, 0], ies = '', intensity = 1, power = 1 }"),
        "`intensity` and `power` are both given"
    );
    let disk = |keys: &str| {
        message(&format!(
            "disk = {{ position = [0, 1, 0], direction = [0, -1, 0], radius = 1, ies = '', {keys} }}"
        ))
    };
    assert_eq!(disk("radiance = 1"), "a light with `ies` has no `radiance`");
    assert_eq!(disk("spread = 0.5"), "`spread` and `ies` are both given");
}

#[test]
fn lamps_whose_power_is_too_small_for_a_number_are_dark() {
    let tiny = profile(|v, _| if v < 1.0 { 1e-41 } else { 0.0 });
    for text in [
        "point = { position = [0, 2, 0], ies = '', power = 1 }",
        "disk = { position = [0, 2, 0], ies = '', direction = [0, -1, 0], radius = 0.1, power = 1 }",
    ] {
        let e = irradiance(&light(text), &tiny, Vec3::ZERO);
        assert!(e.is_finite(), "{text}: {e}");
    }
}
