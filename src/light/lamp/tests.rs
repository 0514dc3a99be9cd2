//! Lights with a surface: what light sampling finds is what rays find, and the power is that of the file.

use crate::{
    light::{Light, LightDesc, LightFind, LightSample, LightTables},
    math::{DVec3, Ray, Vec2, Vec3, hash::mix32, hash::unit_f32},
};

const LAMPS: [&str; 10] = [
    "rect = { position = [1, 3, 2], target = [0, 0, 0], size = [2, 1], power = 60, temperature = 4000 }",
    "rect = { position = [0, 3, 0], direction = [0, -1, 0], size = [0.1, 4], radiance = [1, 2, 3], two_sided = true }",
    "rect = { position = [0, 3, 0], direction = [0.1, -1, 0], size = [1, 1], power = 9, spread = 0.3 }",
    "disk = { position = [0, 3, 0], direction = [0, -1, 0.5], radius = 0.5, power = 40, spread = 0.7 }",
    "rect = { position = [0, 6, 0], direction = [0.1, -1, 0.2], size = [6, 5], power = 9, spread = 0.05, two_sided = true }",
    "disk = { position = [0, 6, 0], direction = [0.1, -1, 0.2], radius = 3, power = 9, spread = 0.1 }",
    "sphere = { position = [0, 2.5, 0], radius = 0.4, power = 60, exposure = 1.5 }",
    "tube = { from = [-1, 2.5, 0], to = [1, 2.5, 0.5], radius = 0.1, power = 36 }",
    "point = { position = [0, 3, 0], power = 100, radius = 0.3 }",
    "spot = { position = [0, 5, 0], target = [0, 0, 0], cone_angle = 40, penumbra_angle = 15, intensity = 100, radius = 0.2 }",
];

/// No light here refers to a table.
const NONE: LightTables = LightTables::NONE;

fn light(text: &str) -> Light {
    let desc: LightDesc = toml::from_str(text).expect("a light");
    desc.compile(&LightFind::nothing(DVec3::ZERO)).expect("a valid light")
}

/// Points around the lamps, and random numbers.
fn places() -> impl Iterator<Item = (Vec3, Vec2)> {
    let number = |i: u32, k: u32| unit_f32(mix32(i.wrapping_mul(31).wrapping_add(k)));
    (0..400).map(move |i| {
        let from = Vec3::new(number(i, 1), number(i, 2), number(i, 3)) * Vec3::new(8.0, 5.0, 8.0);
        (from - Vec3::new(4.0, 0.0, 4.0), Vec2::new(number(i, 4), number(i, 5)))
    })
}

#[test]
fn a_ray_along_a_sample_finds_the_light_and_the_density_of_the_sample() {
    for text in LAMPS {
        let lamp = light(text);
        let (surface, _) = lamp.surface().expect("a surface");
        let mut found = 0;
        for (from, u) in places() {
            let Some(LightSample { wi, distance, li, pdf }) = lamp.sample(&NONE, from, u) else {
                continue;
            };
            // Samples lie in front of the surface by the rounding: that moves the hits of rays that graze it.
            let Some(hit) = surface.intersect(&Ray::new(from, wi)) else {
                continue;
            };
            let cos = surface.surface(&Ray::new(from, wi), &hit).ng.dot(wi);
            if cos.abs() < 0.5 || (hit.t - distance).abs() > 1e-3 {
                continue;
            }
            let (radiance, density) = lamp.seen(&NONE, from, wi, &hit);
            let pdf = pdf.expect("a density");
            assert!(
                (radiance.r - li.r).abs() <= 2e-3 * li.r + 1e-5,
                "{text}: {radiance:?} and {li:?}"
            );
            assert!((density - pdf).abs() <= 2e-3 * pdf, "{text}: {density} and {pdf}");
            found += 1;
        }
        // Focused light reaches few places.
        assert!(found > 5, "{text}: {found}");
    }
}

#[test]
fn the_light_through_a_sphere_around_a_lamp_is_its_power() {
    let shining = |text: &str| {
        let lamp = light(text);
        let (n, far, center) = (160, 400.0, DVec3::new(0.0, 3.0, 0.0));
        let mut power = 0.0;
        for i in 0..n {
            for k in 0..n {
                // Equal areas on the sphere.
                let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(n);
                let phi = std::f64::consts::TAU * (f64::from(k) + 0.5) / f64::from(n);
                let r = (1.0 - z * z).sqrt();
                let d = DVec3::new(r * libm::cos(phi), z, r * libm::sin(phi));
                let u = Vec2::new(unit_f32(mix32(i * 977 + k)), unit_f32(mix32(k * 131 + i)));
                let sample = lamp.sample(&NONE, (center + d * far).as_vec3(), u);
                let flux = sample.and_then(|s| Some(f64::from(s.li.g / s.pdf?)));
                power += flux.unwrap_or(0.0);
            }
        }
        power * 4.0 * std::f64::consts::PI * far * far / f64::from(n * n)
    };
    let cases = [
        (
            "rect = { position = [0, 3, 0], direction = [0.3, -1, 0.2], size = [2, 1], power = 60 }",
            60.0,
        ),
        (
            "rect = { position = [0, 3, 0], direction = [0.3, -1, 0.2], size = [2, 1], power = 60, two_sided = true }",
            60.0,
        ),
        (
            "rect = { position = [0, 3, 0], direction = [0.3, -1, 0.2], size = [2, 1], power = 60, spread = 0.5 }",
            60.0,
        ),
        (
            "disk = { position = [0, 3, 0], direction = [0, -1, 0], radius = 0.5, power = 60, spread = 0.8 }",
            60.0,
        ),
        (
            "sphere = { position = [0, 3, 0], radius = 0.5, power = 60, exposure = -1 }",
            30.0,
        ),
        (
            "tube = { from = [-1, 3, 0], to = [1, 3, 0], radius = 0.1, power = 60 }",
            60.0,
        ),
        ("point = { position = [0, 3, 0], power = 60, radius = 0.2 }", 60.0),
        ("point = { position = [0, 3, 0], intensity = 5, radius = 0.2 }", 62.832),
    ];
    for (text, expected) in cases {
        let power = shining(text);
        assert!((power / expected - 1.0).abs() < 0.01, "{text}: {power} W");
    }
}

/// The irradiance at `from` on a surface that faces a unit direction, by this many samples, and the share
/// of the samples that bring light.
fn irradiance(lamp: &Light, from: Vec3, facing: Vec3, side: u32) -> (f64, f64) {
    let (mut sum, mut lit) = (0.0, 0.0);
    for i in 0..side * side {
        let u = Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
        if let Some(LightSample { wi, li, pdf, .. }) = lamp.sample(&NONE, from, u) {
            sum += f64::from(li.g * wi.dot(facing).max(0.0) / pdf.unwrap_or(1.0));
            lit += 1.0;
        }
    }
    (sum / f64::from(side * side), lit / f64::from(side * side))
}

#[test]
fn the_irradiance_within_a_narrow_beam_is_the_power_by_the_area() {
    // By reciprocity an even surface that fills all directions of a beam has the irradiance of its exitance.
    let (rect, disk) = (60.0 / 6.0, 60.0 / (std::f64::consts::PI * 2.25));
    for spread in [0.0, 5e-5, 1e-4, 1e-3, 0.01, 0.1, 0.2] {
        let of = |shape: &str| {
            let axis = "position = [1, 3, 2], direction = [0, -1, 0], power = 60";
            light(&format!("{shape}, {axis}, spread = {spread} }}"))
        };
        let lamps = [
            (of("rect = { size = [3, 2]"), rect),
            (of("disk = { radius = 1.5"), disk),
            (of("rect = { size = [3, 2], two_sided = true"), rect / 2.0),
        ];
        for (lamp, expected) in &lamps {
            for from in [[1.0, 1.9, 2.0], [1.8, 2.6, 1.6], [0.5, 2.99, 2.7]] {
                let (found, lit) = irradiance(lamp, from.into(), Vec3::Y, 64);
                assert!(
                    (found / expected - 1.0).abs() < 0.01,
                    "{spread} at {from:?}: {found}, not {expected}"
                );
                assert!(spread > 0.1 || lit > 0.75, "{spread} at {from:?}: {lit} of the samples");
            }
        }
        // Beside the beam, and behind the light.
        for from in [[2.8, 2.5, 2.0], [1.0, 2.5, 3.8], [1.0, 3.5, 2.0]] {
            assert_eq!(irradiance(&lamps[0].0, from.into(), Vec3::Y, 8), (0.0, 0.0), "{spread}");
        }
        let behind = irradiance(&lamps[2].0, Vec3::new(1.0, 3.5, 2.0), Vec3::NEG_Y, 64).0;
        assert!((behind / lamps[2].1 - 1.0).abs() < 0.01, "{spread}: {behind}");
    }
}

#[test]
fn a_parallel_beam_is_a_light_without_size_whose_irradiance_does_not_fall() {
    let lamp = light(
        "disk = { position = [0, 3, 0], direction = [0, -1, 0], radius = 1, radiance = 2, spread = 0, camera = true }",
    );
    assert!(lamp.bounds(&NONE).is_none() && lamp.surface().is_none() && !lamp.has_size());
    for height in [2.9, 0.0, -1e3] {
        let from = Vec3::new(0.6, height, 0.7);
        let sample = lamp.sample(&NONE, from, Vec2::ZERO).expect("lit");
        assert!(lamp.reaches(from, Vec3::Y) && !lamp.reaches(from, Vec3::NEG_Y));
        assert_eq!((sample.pdf, sample.li.g), (None, 2.0 * std::f32::consts::PI));
        assert!((sample.wi - Vec3::Y).length() < 1e-6, "{}", sample.wi);
        assert!((sample.distance / (3.0 - height) - 1.0).abs() < 1e-3);
    }
    assert!(!lamp.reaches(Vec3::new(0.8, 0.0, 0.7), Vec3::Y) && !lamp.reaches(Vec3::new(0.0, 4.0, 0.0), Vec3::NEG_Y));
}

#[test]
fn the_spread_ends_the_light_at_its_angle() {
    let lamp = light("disk = { position = [0, 0, 0], direction = [0, -1, 0], radius = 0.01, power = 1, spread = 0.5 }");
    let lit = |degrees: f32| {
        let (sin, cos) = libm::sincosf(degrees.to_radians());
        lamp.sample(&NONE, Vec3::new(sin, -cos, 0.0) * 50.0, Vec2::splat(0.5))
            .is_some()
    };
    assert!(lit(0.0) && lit(44.0) && !lit(46.0) && !lit(170.0));
}

#[test]
fn a_light_that_no_ray_finds_brings_the_same_light_without_a_density() {
    let with = |keys: &str| {
        light(&format!(
            "sphere = {{ position = [0, 2.5, 0], radius = 0.4, power = 60{keys} }}"
        ))
    };
    let (seen, hidden) = (with(""), with(", reflections = false"));
    for (from, u) in places() {
        let (Some(a), Some(b)) = (seen.sample(&NONE, from, u), hidden.sample(&NONE, from, u)) else {
            continue;
        };
        let pdf = a.pdf.expect("a density");
        assert_eq!(b.pdf, None);
        assert!((a.li.r / pdf - b.li.r).abs() <= 1e-6 * b.li.r);
    }
}

#[test]
fn wrong_lamps_are_refused_in_words() {
    let message = |text: &str| {
        let desc: LightDesc = toml::from_str(text).expect("a light");
        desc.compile(&LightFind::nothing(DVec3::ZERO))
            .expect_err("refused")
            .message
    };
    let rect = |keys: &str| message(&format!("rect = {{ position = [0, 1, 0], size = [1, 1], {keys} }}"));
    assert_eq!(rect("power = 1"), "a rect needs `target` or `direction`");
    let down = "direction = [0, -1, 0]";
    assert_eq!(rect(down), "give its strength by `power` or by `radiance`");
    assert_eq!(
        rect(&format!("{down}, power = 1, radiance = 1")),
        "`power` and `radiance` are both given"
    );
    assert_eq!(
        message("tube = { from = [0, 1, 0], to = [0, 1, 0], radius = 1, power = 1 }"),
        "`to` lies at `from`"
    );
    let no_area = "the light has no area: it is too small for its place";
    let (place, strength) = ("position = [0, 1, 0], direction = [0, -1, 0]", "radiance = 1");
    for small in [
        format!("rect = {{ {place}, size = [1e-30, 1e-30], {strength} }}"),
        format!("rect = {{ {place}, size = [1, 1e-9], {strength} }}"),
        format!("disk = {{ {place}, radius = 1e-30, {strength} }}"),
        format!("sphere = {{ position = [0, 1, 0], radius = 1e-30, {strength} }}"),
        format!("tube = {{ from = [0, 1, 0], to = [0, 2, 0], radius = 1e-39, {strength} }}"),
    ] {
        assert_eq!(message(&small), no_area, "{small}");
    }
    assert_eq!(
        message("point = { position = [0, 1, 0], intensity = 1, falloff = 'none', radius = 1 }"),
        "a light without falloff has no `radius`"
    );
    assert_eq!(
        message("point = { position = [0, 1, 0] }"),
        "give its strength by `intensity` or by `power`"
    );
}
