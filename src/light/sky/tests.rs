//! Properties of skies.

use toml::de;

use super::*;
use crate::math::{Vec3, trig};

fn sky(text: &str) -> Result<Sky, Problem> {
    de::from_str::<SkyDesc>(text).expect("a description").compile(0..0)
}

#[test]
fn the_sun_is_clockwise_from_minus_z_and_above_the_horizon() {
    for (text, expected) in [
        ("elevation = 0", Vec3::NEG_Z),
        ("elevation = 90\nazimuth = 20", Vec3::Y),
        ("elevation = 0\nazimuth = 90", Vec3::X),
        ("elevation = 0\nazimuth = 90\nrotate = [0, 90, 0]", Vec3::NEG_Z),
        ("elevation = 90\nrotate = [90, 0, 0]", Vec3::Z),
        ("elevation = 30\nazimuth = 180", Vec3::new(0.0, 0.5, 0.75_f32.sqrt())),
    ] {
        let found = sky(text).expect("a sky").to_sun().as_vec3();
        assert!((found - expected).length() < 1e-5, "{text}: {found}");
    }
    // In the south and in the west of Munich.
    let place = "latitude = 48.1\nlongitude = 11.6\nutc_offset = 2\ndate = \"2026-06-21\"";
    let noon = sky(&format!("{place}\ntime = 13.25")).expect("a sky").to_sun();
    assert!(noon.z > 0.4 && noon.y > 0.89 && noon.x.abs() < 0.02, "{noon}");
    let evening = sky(&format!("{place}\ntime = 20")).expect("a sky").to_sun();
    assert!(evening.x < -0.8 && evening.y > 0.1, "{evening}");
}

#[test]
fn what_a_sky_cannot_be_is_told() {
    for (text, expected) in [
        ("turbidity = 2", "the sun has no position"),
        ("elevation = 91", "expected an elevation from -90 to 90, found 91"),
        (
            "elevation = 9\nturbidity = 0.5",
            "expected a turbidity from 1 to 10, found 0.5",
        ),
        ("elevation = 9\ntime = 4", "`time` without `date`"),
        (
            "elevation = 9\ndate = \"2026-06-21\"",
            "the sun has a position beside that by `date`",
        ),
        (
            "date = \"2026-02-29\"",
            "expected a date as \"2026-06-21\", found \"2026-02-29\"",
        ),
        (
            "date = \"26-6-2\"",
            "expected a date as \"2026-06-21\", found \"26-6-2\"",
        ),
        (
            "date = \"2024-02-29\"\nlatitude = 100",
            "expected a latitude from -90 to 90, found 100",
        ),
        ("elevation = 9\nground_albedo = 1.5", "expected an albedo of at most 1"),
    ] {
        assert_eq!(sky(text).expect_err(text).message, expected);
    }
}

#[test]
fn light_of_sky_and_sun_is_that_of_clear_days() {
    let (environment, sun) = sky("elevation = 50\nground_albedo = 0")
        .expect("a sky")
        .bake(WorkingSpace::Rec709);
    let side = 120;
    let (mut up, mut count) = (Rgb::BLACK, 0);
    for k in 0..side * side {
        let (y, around) = (
            ((k / side) as f32 + 0.5) / side as f32,
            std::f32::consts::TAU * ((k % side) as f32 + 0.5) / side as f32,
        );
        let (sin, cos) = trig::sin_cos(around);
        let across = (1.0 - y * y).sqrt();
        up += environment.radiance(Vec3::new(across * cos, y, across * sin)) * (y * std::f32::consts::TAU);
        count += 1;
    }
    let (sky, sun) = (up / count as f32, sun.irradiance);
    // The ratio of the light of the sky to that of the sun on the ground, and their colours.
    let ratio = sky.luminance() / (sun.luminance() * libm::sinf(0.872_664_6));
    assert!((0.12..0.25).contains(&ratio), "{ratio}");
    assert!(sky.b > 1.5 * sky.r && sun.r > 1.3 * sun.b, "{sky:?} {sun:?}");
    // The ground is black.
    assert!(environment.radiance(Vec3::new(0.0, -1.0, 0.0)).luminance() < 1e-4);
}

#[test]
fn a_sun_below_the_horizon_does_not_shine_and_leaves_some_twilight() {
    let (environment, sun) = sky("elevation = -4").expect("a sky").bake(WorkingSpace::Rec709);
    assert!(sun.irradiance.is_black());
    let west = environment.radiance(Vec3::new(0.0, 0.1, -1.0).normalize());
    let east = environment.radiance(Vec3::new(0.0, 0.1, 1.0).normalize());
    assert!(
        west.luminance() > 2.0 * east.luminance() && west.luminance() < 0.01,
        "{west:?} {east:?}"
    );
}
