//! Properties of environment maps.

use std::f64::consts::PI;

use super::*;
use crate::math::{DVec3, Plain, transform::axis_rotation};

fn picture(width: u32, height: u32, texel: impl Fn(u32, u32) -> f32) -> Bitmap {
    let values = (0..width * height)
        .flat_map(|i| [texel(i % width, i / width); 3])
        .collect();
    Bitmap::from_floats([width, height], 3, values)
}

fn environment(width: u32, height: u32, texel: impl Fn(u32, u32) -> f32) -> Environment {
    Environment::new(
        &picture(width, height, texel),
        WorkingSpace::Rec709,
        1.0,
        DMat3::IDENTITY,
    )
}

/// The middles of a fine grid over the unit square.
fn grid(side: u32) -> impl Iterator<Item = Vec2> {
    (0..side * side).map(move |i| Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32)
}

/// Directions, evenly spread.
fn directions(side: u32) -> impl Iterator<Item = Vec3> {
    grid(side).map(|u| {
        let y = f64::from(1.0 - 2.0 * u.y);
        let (r, phi) = ((1.0 - y * y).sqrt(), 2.0 * PI * f64::from(u.x));
        DVec3::new(r * libm::cos(phi), y, r * libm::sin(phi)).as_vec3()
    })
}

#[test]
fn six_bright_texels_shine_from_the_six_axes() {
    let (w, h) = (64, 32);
    for (axis, x, y) in [
        (-Vec3::Z, 32, 16),
        (Vec3::X, 48, 16),
        (Vec3::Z, 0, 16),
        (-Vec3::X, 16, 16),
    ] {
        // The texel's first corner lies on the axis: so do those of its neighbours.
        let bright = |i: u32, j: u32| [x, (x + w - 1) % w].contains(&i) && [y, y - 1].contains(&j);
        let e = environment(w, h, |i, j| f32::from(u8::from(bright(i, j))));
        assert!((e.radiance(axis).r - 1.0).abs() < 1e-4, "{axis}");
        // A texel's light reaches the middles of its neighbours, not their far sides.
        for s in grid(20).filter_map(|u| e.sample(Plain, u)) {
            assert!(s.wi.dot(axis) > 0.95, "{} is not {axis}", s.wi);
        }
    }
    for (axis, row) in [(Vec3::Y, 0), (-Vec3::Y, h - 1)] {
        let e = environment(w, h, |_, j| f32::from(u8::from(j == row)));
        assert!((e.radiance(axis).r - 1.0).abs() < 1e-4, "{axis}");
        assert!(
            grid(20)
                .filter_map(|u| e.sample(Plain, u))
                .all(|s| s.wi.dot(axis) > 0.95)
        );
    }
}

#[test]
fn a_rotation_turns_the_picture_about_the_fixed_axes() {
    let bright = |i: u32, j: u32| f32::from(u8::from((31..=32).contains(&i) && (15..=16).contains(&j)));
    // -z goes to -x by 90 degrees about y, and to +y by 90 about x.
    for (rotation, axis) in [(axis_rotation(1, 90.0), -Vec3::X), (axis_rotation(0, 90.0), Vec3::Y)] {
        let e = Environment::new(&picture(64, 32, bright), WorkingSpace::Rec709, 2.0, rotation);
        assert!((e.radiance(axis).r - 2.0).abs() < 1e-4, "{axis}");
        assert!(
            grid(10)
                .filter_map(|u| e.sample(Plain, u))
                .all(|s| s.wi.dot(axis) > 0.95)
        );
        assert!(grid(10).any(|u| e.sample(Plain, u).is_some()));
    }
}

/// A sky of broad stripes with a sun of a few texels, at 4 x 4 texels to a cell.
fn sunny(i: u32, j: u32) -> f32 {
    let is_sun = (402..=406).contains(&i) && (77..=80).contains(&j);
    1.0 + (i / 100) as f32 + if is_sun { 1e4 } else { 0.0 }
}

#[test]
fn samples_and_pdf_agree_and_the_density_adds_up_to_one() {
    let texel = |i: u32, j: u32| ((i * 31 + j * 17) % 13) as f32;
    let e = environment(24, 11, texel);
    for u in grid(70) {
        let s = e.sample(Plain, u).expect("a direction");
        let pdf = s.pdf.expect("it has size");
        assert!((s.li.r - e.radiance(s.wi).r).abs() < 1e-3);
        let told = e.pdf(s.wi);
        // Between two patches rounding may take either.
        let at = e.map_point(s.wi) + 0.5;
        let inside = (at - at.floor() - 0.5).abs().max_element() < 0.499;
        assert!(!inside || (told / pdf - 1.0).abs() < 1e-3, "{told} is not {pdf}");
    }
    let side = 500;
    let sum: f64 = directions(side).map(|w| f64::from(e.pdf(w))).sum();
    let integral = sum * 4.0 * PI / f64::from(side * side);
    assert!((integral - 1.0).abs() < 2e-3, "{integral}");
}

#[test]
fn samples_and_pdf_agree_in_cells_with_a_table_of_texels_and_without() {
    let e = environment(603, 301, sunny);
    let bright = grid(70).filter(|u| {
        let s = e.sample(Plain, *u).expect("a direction");
        let (told, pdf) = (e.pdf(s.wi), s.pdf.expect("it has size"));
        let at = e.map_point(s.wi) + 0.5;
        let inside = (at - at.floor() - 0.5).abs().max_element() < 0.49;
        assert!(!inside || (told / pdf - 1.0).abs() < 1e-3, "{told} is not {pdf}");
        s.li.r > 100.0
    });
    // The sun has 84 % of the light above the mean.
    assert!((4000..4250).contains(&bright.count()));
    let edge = |j: usize| libm::cos(PI * (j as f64 - 0.5).clamp(0.0, e.height as f64) / e.height as f64);
    // Between the centres of texels the density is bilinear.
    let row = |j: usize| {
        let y = libm::acos(0.5 * (edge(j) + edge(j + 1))) / PI * e.height as f64;
        let at = |i: usize| MapPoint::new(i as f32, y as f32);
        let densities: f64 = (0..e.width).map(|i| f64::from(e.pdf_at(at(i)))).sum();
        densities * 2.0 * PI / e.width as f64 * (edge(j) - edge(j + 1))
    };
    let integral: f64 = (0..=e.height).map(row).sum();
    assert!((integral - 1.0).abs() < 1e-5, "{integral}");
}

#[test]
fn samples_of_a_sun_of_few_texels_bring_the_same_light_each() {
    // In a black sky, of 1 texel, 9 and 53, in maps whose cells have one patch and many.
    for (radius, w, h) in [(0.5, 603, 301), (4.1, 603, 301), (0.5, 64, 32), (1.5, 64, 32)] {
        let e = environment(w, h, |i, j| {
            let (x, y) = (f64::from(i) - f64::from(w / 3), f64::from(j) - f64::from(h / 3));
            f32::from(u8::from(x * x + y * y < radius * radius)) * 1e4
        });
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        for u in grid(100) {
            let light = e
                .sample(Plain, u)
                .map_or(0.0, |s| f64::from(s.li.g / s.pdf.expect("it has size")));
            (sum, squares, count) = (sum + light, squares + light * light, count + 1.0);
        }
        let variance = squares * count / (sum * sum) - 1.0;
        assert!(variance < 2e-3, "{radius} of {w} x {h}: {variance}");
    }
}

#[test]
fn a_small_sun_gets_the_share_of_samples_that_it_has_of_the_light() {
    let (w, h) = (603, 301);
    let e = environment(w, h, sunny);
    let sky = |i, j| f64::from(sunny(i, j).min(10.0));
    let edge = |j: u32| libm::cos(PI * f64::from(j) / f64::from(h));
    let texels = (0..h).flat_map(|j| (0..w).map(move |i| (i, j, edge(j) - edge(j + 1))));
    let (whole, area) = texels.clone().fold((0.0, 0.0), |(sum, area), (i, j, a)| {
        (sum + f64::from(sunny(i, j)) * a, area + a)
    });
    let mean = whole / area;
    let above = |l: f64| (l - mean).max(0.0);
    let (sun, all) = texels.fold((0.0, 0.0), |(sun, all), (i, j, a)| {
        let own = above(f64::from(sunny(i, j))) * a;
        (sun + own - above(sky(i, j)) * a, all + own)
    });
    // Interpolation widens it by half a texel.
    let in_sun = |s: &LightSample| {
        let at = e.map_point(s.wi);
        (401.0..408.0).contains(&at.x) && (76.0..82.0).contains(&at.y)
    };
    let found = grid(100).filter_map(|u| e.sample(Plain, u)).filter(in_sun).count() as f64 / 1e4;
    assert!(
        sun / all > 0.3 && (found - sun / all).abs() < 0.02,
        "{found} of {}",
        sun / all
    );
}

#[test]
fn texels_keep_their_light_from_a_dim_sky_to_a_sun_beyond_halves() {
    for sun in [1.0, 7e4, 1e6, 3e8] {
        let values = [sun, 0.01, 0.3, 40.0, 1e-3, 2.0];
        let e = environment(6, 2, |i, _| values[i as usize]);
        for (i, expected) in (0..6).zip(values) {
            let found = e.at(MapPoint::new(i as f32 + 0.5, 1.0)).r;
            assert!((found - expected).abs() <= 1e-6 * expected, "{expected}: {found}");
        }
    }
    assert_eq!(size_of_val(&environment(1, 1, |_, _| 1.0).texels[0]), 12);
}

#[test]
fn directions_are_chosen_as_texels_are_brighter_than_the_mean() {
    // Smooth, so that a texel's mean is near its middle's.
    let bright = |w: Vec3| 1.0 + w.y + 0.5 * w.x;
    let (w, h) = (64, 32);
    let probe = environment(w, h, |_, _| 0.0);
    let middle = |i: u32, j: u32| {
        let theta = PI * (f64::from(j) + 0.5) / f64::from(h);
        let phi = 2.0 * PI * ((f64::from(i) + 0.5) / f64::from(w) - 0.5);
        DVec3::new(
            libm::sin(theta) * libm::sin(phi),
            libm::cos(theta),
            -libm::sin(theta) * libm::cos(phi),
        )
        .as_vec3()
    };
    let e = environment(w, h, |i, j| bright(middle(i, j)));
    // What is more than the mean, 1, of all directions.
    let excess = |d: Vec3| f64::from((bright(d) - 1.0).max(0.0));
    let total: f64 = directions(300).map(excess).sum::<f64>() * 4.0 * PI / 90_000.0;
    let (mut counts, draws) = (vec![0_u32; 32], 300);
    for u in grid(draws) {
        let at = probe.map_point(e.sample(Plain, u).expect("a direction").wi);
        counts[(at.x as usize / 8).min(7) + 8 * (at.y as usize / 8).min(3)] += 1;
    }
    let edge = |j: u32| libm::cos(PI * f64::from(j) / f64::from(h));
    let solid_angle = |j: u32| 2.0 * PI / f64::from(w) * (edge(j) - edge(j + 1));
    for (block, count) in counts.into_iter().enumerate() {
        let texels = (0..64).map(|k| ((block % 8 * 8 + k % 8) as u32, (block / 8 * 8 + k / 8) as u32));
        let weight: f64 = texels.map(|(i, j)| excess(middle(i, j)) * solid_angle(j)).sum();
        let expected = weight / total * f64::from(draws * draws);
        assert!(
            (f64::from(count) - expected).abs() < 0.03 * expected + 60.0,
            "{block}: {count} is not {expected}"
        );
    }
}

#[test]
fn light_by_both_ways_adds_up_to_the_whole_picture() {
    // The irradiance of surfaces that face up and sideways, by samples where there is a density and
    // by all directions elsewhere.
    let e = environment(
        32,
        16,
        |i, j| if (i, j) == (9, 3) { 400.0 } else { 0.2 + (j % 3) as f32 },
    );
    for n in [Vec3::Y, Vec3::new(-0.6, 0.0, -0.8)] {
        let cos = |w: Vec3| f64::from(n.dot(w).max(0.0));
        let side = 400;
        let area = 4.0 * PI / f64::from(side * side);
        let whole: f64 = directions(side)
            .map(|w| f64::from(e.radiance(w).g) * cos(w))
            .sum::<f64>()
            * area;
        let rest: f64 = directions(side)
            .filter(|w| e.pdf(*w) == 0.0)
            .map(|w| f64::from(e.radiance(w).g) * cos(w))
            .sum::<f64>()
            * area;
        let draws = 200;
        let sampled: f64 = grid(draws)
            .filter_map(|u| e.sample(Plain, u))
            .map(|s| f64::from(s.li.g) * cos(s.wi) / f64::from(s.pdf.expect("it has size")))
            .sum::<f64>()
            / f64::from(draws * draws);
        assert!(
            ((sampled + rest) / whole - 1.0).abs() < 0.01,
            "{n}: {sampled} + {rest} is not {whole}"
        );
    }
}

#[test]
fn a_picture_of_one_colour_is_not_sampled() {
    for v in [0.0, 0.37] {
        let e = environment(16, 8, |_, _| v);
        assert!(!e.is_sampled() && e.pdf(Vec3::Y) == 0.0 && e.sample(Plain, Vec2::splat(0.5)).is_none());
        assert!(directions(20).all(|w| (e.radiance(w).g - v).abs() < 1e-6));
    }
}

#[test]
fn what_is_no_light_is_counted_and_replaced() {
    let picture = picture(4, 2, |i, j| match (i, j) {
        (0, 0) => f32::NAN,
        (1, 0) => f32::INFINITY,
        (2, 0) => -3.0,
        _ => 1.0,
    });
    assert_eq!(picture.repaired, 6);
    let e = Environment::new(&picture, WorkingSpace::Rec709, 1.0, DMat3::IDENTITY);
    assert_eq!(e.clamped, 1);
    assert!(directions(40).all(|w| e.radiance(w).r >= 0.0 && e.radiance(w).is_finite()));
}
