//! Intensities at the angles of a file, their symmetries, and the power.

use super::*;
use crate::math::{hash::mix32, hash::unit_f32};

fn number(i: u32) -> f32 {
    unit_f32(mix32(i))
}

/// A measurement with these angles and random intensities.
fn measured(photometry: Photometry, vertical: &[f32], horizontal: &[f32], symmetry: Symmetry) -> Measurement {
    let count = (vertical.len() * horizontal.len()) as u32;
    let mut candela: Vec<f32> = (0..count).map(|i| 683.0 * (0.2 + number(i + 7))).collect();
    if horizontal.ends_with(&[360.0]) {
        candela.copy_within(..vertical.len(), count as usize - vertical.len());
    }
    Measurement {
        photometry,
        vertical: vertical.to_vec(),
        horizontal: horizontal.to_vec(),
        symmetry,
        candela,
    }
}

/// The direction of two angles in degrees, in the lamp's own space.
fn direction(photometry: Photometry, vertical: f32, horizontal: f32) -> Vec3 {
    let [(sin_v, cos_v), (sin_h, cos_h)] = [vertical, horizontal].map(|a| libm::sincosf(a.to_radians()));
    match photometry {
        // Horizontal angles grow from up to the left.
        Photometry::C => Vec3::new(-sin_v * sin_h, sin_v * cos_h, cos_v),
        Photometry::A => Vec3::new(cos_v * sin_h, sin_v, cos_v * cos_h),
        Photometry::B => Vec3::new(sin_h, cos_h * sin_v, cos_h * cos_v),
    }
}

const FULL: [f32; 5] = [0.0, 70.0, 180.0, 290.0, 360.0];
const FRONT: [f32; 5] = [-90.0, -40.0, 5.0, 30.0, 90.0];

fn all() -> Vec<Measurement> {
    use Photometry::{A, B, C};
    let down = [0.0, 20.0, 55.0, 90.0];
    let whole = [0.0, 10.0, 90.0, 120.0, 180.0];
    vec![
        measured(C, &down, &[0.0], Symmetry::Axial),
        measured(C, &whole, &[0.0, 30.0, 90.0], Symmetry::Quadrants),
        measured(C, &down, &[0.0, 45.0, 180.0], Symmetry::Mirrored),
        measured(C, &whole, &[90.0, 150.0, 270.0], Symmetry::Mirrored),
        measured(C, &[90.0, 100.0, 180.0], &FULL, Symmetry::None),
        measured(C, &whole, &[0.0, 90.0, 180.0, 270.0], Symmetry::Closed),
        measured(A, &FRONT, &FRONT, Symmetry::None),
        measured(B, &FRONT, &FRONT, Symmetry::None),
        measured(A, &[0.0, 20.0, 50.0], &[0.0, 10.0, 60.0], Symmetry::AboutZero),
        measured(B, &[0.0, 20.0, 50.0], &[0.0, 10.0, 60.0], Symmetry::AboutZero),
    ]
}

#[test]
fn the_intensity_at_the_angles_of_a_file_is_that_of_the_file() {
    for m in all() {
        let profile = Profile::new(&m);
        for (row, h) in m.horizontal.iter().enumerate() {
            for (column, v) in m.vertical.iter().enumerate() {
                // At a pole all planes meet, and at the edge rounding leads out.
                let is_inside = |a: f32| a.abs() > 0.0 && a.abs() < 89.9 || (a > 90.1 && a < 179.9);
                let is_last = m.vertical.last() == Some(v) || m.horizontal.last() == Some(h);
                if !is_inside(*v) || (m.photometry != Photometry::C && (!is_inside(*h) || is_last)) {
                    continue;
                }
                let expected = m.candela[row * m.vertical.len() + column] / 683.0;
                let found = profile.intensity(direction(m.photometry, *v, *h));
                assert!(
                    (found / expected - 1.0).abs() < 1e-4,
                    "{m:?} {v} {h}: {found} {expected}"
                );
            }
        }
    }
}

#[test]
fn symmetries_repeat_what_is_listed() {
    use Photometry::{A, B, C};
    let whole = [0.0, 10.0, 90.0, 120.0, 180.0];
    let same = |m: &Measurement, angles: &[(f32, f32)]| {
        let profile = Profile::new(m);
        let found: Vec<f32> = angles
            .iter()
            .map(|(v, h)| profile.intensity(direction(m.photometry, *v, *h)))
            .collect();
        let (low, high) = (
            found.iter().copied().fold(f32::MAX, f32::min),
            found.iter().copied().fold(0.0, f32::max),
        );
        assert!(low > 0.0 && high - low < 2e-4 * high, "{m:?}: {found:?}");
    };
    let quadrants = measured(C, &whole, &[0.0, 30.0, 90.0], Symmetry::Quadrants);
    same(&quadrants, &[(70.0, 20.0), (70.0, 160.0), (70.0, 200.0), (70.0, 340.0)]);
    let half = measured(C, &whole, &[0.0, 45.0, 180.0], Symmetry::Mirrored);
    same(&half, &[(70.0, 20.0), (70.0, 340.0)]);
    same(&half, &[(100.0, 100.0), (100.0, 260.0)]);
    let other = measured(C, &whole, &[90.0, 150.0, 270.0], Symmetry::Mirrored);
    same(&other, &[(70.0, 100.0), (70.0, 80.0)]);
    same(&other, &[(70.0, 190.0), (70.0, 350.0)]);
    same(
        &measured(C, &whole, &[0.0], Symmetry::Axial),
        &[(70.0, 1.0), (70.0, 123.0), (70.0, 300.0)],
    );
    for photometry in [A, B] {
        let m = measured(photometry, &[0.0, 20.0, 50.0], &[0.0, 10.0, 60.0], Symmetry::AboutZero);
        same(&m, &[(12.0, 33.0), (-12.0, 33.0), (12.0, -33.0), (-12.0, -33.0)]);
    }
}

#[test]
fn directions_without_angles_are_dark() {
    let dark = |m: &Measurement, v, h| Profile::new(m).intensity(direction(m.photometry, v, h)) == 0.0;
    let [down, up] = [&all()[0], &all()[4]].map(Clone::clone);
    assert!(dark(&down, 91.0, 0.0) && !dark(&down, 89.0, 0.0));
    assert!(dark(&up, 89.0, 10.0) && !dark(&up, 91.0, 10.0) && !dark(&up, 180.0, 0.0));
    for m in &all()[8..] {
        assert!(dark(m, 51.0, 0.0) && dark(m, 0.0, 61.0) && dark(m, 0.0, 170.0) && !dark(m, -49.0, -59.0));
    }
}

/// The integral of the intensity over the sphere, by equal solid angles.
fn integral(profile: &Profile, is_counted: impl Fn(Vec3) -> bool) -> f64 {
    let n = 500;
    let mut sum = 0.0;
    for i in 0..n * n {
        let z = 1.0 - 2.0 * (f64::from(i / n) + 0.5) / f64::from(n);
        let phi = 2.0 * PI * (f64::from(i % n) + 0.5) / f64::from(n);
        let r = (1.0 - z * z).sqrt();
        let w = Vec3::new((r * libm::cos(phi)) as f32, (r * libm::sin(phi)) as f32, z as f32);
        if is_counted(w) {
            sum += f64::from(profile.intensity(w));
        }
    }
    sum * 4.0 * PI / f64::from(n * n)
}

#[test]
fn the_power_is_the_integral_of_the_intensity() {
    for m in all() {
        let profile = Profile::new(&m);
        let (whole, front) = (integral(&profile, |_| true), integral(&profile, |w| w.z > 0.0));
        for (found, expected) in [(profile.power(), whole), (profile.front_power(), front)] {
            let error = (f64::from(found) - expected).abs();
            assert!(error < 5e-3 * whole, "{m:?}: {found} W, not {expected}");
        }
    }
}

#[test]
fn an_even_lamp_has_4_pi_times_its_intensity_and_a_cosine_pi_times() {
    let degrees: Vec<f32> = (0..=180).map(|v| v as f32).collect();
    let lamp = |candela: &dyn Fn(f32) -> f32| {
        Profile::new(&Measurement {
            photometry: Photometry::C,
            candela: degrees.iter().map(|v| candela(*v)).collect(),
            vertical: degrees.clone(),
            horizontal: vec![0.0],
            symmetry: Symmetry::Axial,
        })
    };
    let near = |found: f32, expected: f64| (f64::from(found) / expected - 1.0).abs() < 1e-4;
    let even = lamp(&|_| 683.0);
    assert!(near(even.power(), 4.0 * PI) && near(even.front_power(), 2.0 * PI));
    let cosine = lamp(&|v| 683.0 * libm::cosf(v.to_radians()).max(0.0));
    assert!(near(cosine.power(), PI) && near(cosine.front_power(), PI));
    let spread = cosine.cone();
    assert!(!spread.is_backward && spread.full < 1e-3 && (spread.end.to_degrees() - 90.0).abs() < 1.01);
}

#[test]
fn no_light_leaves_the_spread() {
    for m in all() {
        let profile = Profile::new(&m);
        let ProfileCone {
            max,
            is_backward,
            full,
            end,
        } = profile.cone();
        let axis = if is_backward { -Vec3::Z } else { Vec3::Z };
        for i in 0..20_000 {
            let w = Vec3::new(number(3 * i), number(3 * i + 1), number(3 * i + 2)) - 0.5;
            let w = w.normalize();
            let (angle, found) = (trig::acos(w.dot(axis)), profile.intensity(w));
            assert!(found <= max * 1.000_01, "{m:?}");
            assert!(found == 0.0 || angle <= end + 1e-3, "{m:?}: {angle} {end}");
            assert!(full <= end, "{m:?}");
        }
    }
}
