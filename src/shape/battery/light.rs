//! Sampling against its density.

use super::examples::{Example, Random, all, bounded, hits, shape};
use crate::{
    math::{Ray, Vec3},
    shape::{Shape, ShapeHit},
};

/// Places to look from: outside, inside, close to the surface and far away.
fn viewpoints(e: &Example, random: &mut Random) -> Vec<Vec3> {
    let mut points = vec![e.center + random.direction() * e.size * 0.1];
    points.extend([0.9, 1.5, 1.5, 20.0].map(|distance| e.center + random.direction() * e.size * distance));
    points
}

/// The hit in the direction of `p`, as near to it as rounding lets one see.
fn hit_at(shape: &Shape, from: Vec3, wi: Vec3, p: Vec3, tolerance: f32) -> Option<(usize, ShapeHit)> {
    let distance = (p - from).length();
    let found = hits(shape, &Ray::new(from, wi));
    found
        .into_iter()
        .map(|(_, hit)| hit)
        .enumerate()
        .find(|(_, hit)| (hit.t - distance).abs() <= tolerance)
}

#[test]
fn samples_lie_on_the_shape_and_pdf_agrees_with_them() {
    for e in bounded() {
        let mut random = Random(11);
        for from in viewpoints(&e, &mut random) {
            let (mut samples, mut missed) = (0, 0);
            for _ in 0..500 {
                let Some(s) = e.shape.sample(from, random.square()) else {
                    continue;
                };
                assert!(s.pdf > 0.0 && s.pdf.is_finite(), "{}: {s:?}", e.text);
                assert!((s.ng.length() - 1.0).abs() < 1e-6, "{}: {s:?}", e.text);
                let wi = (s.p - from).normalize();
                let cos = wi.dot(s.ng).abs();
                if cos < 0.1 {
                    continue;
                }
                samples += 1;
                let tolerance = 1e-5 * (from.length() + e.size) / cos;
                let Some((_, hit)) = hit_at(&e.shape, from, wi, s.p, tolerance) else {
                    missed += 1;
                    continue;
                };
                let at = e.shape.surface(&Ray::new(from, wi), &hit);
                if at.ng.dot(s.ng) > 0.9 {
                    let pdf = e.shape.pdf(from, wi, &hit);
                    assert!((pdf / s.pdf - 1.0).abs() < 2e-3, "{}: {pdf} is not {s:?}", e.text);
                }
            }
            // At the very rim rounding may lead past the shape.
            assert!(missed * 50 <= samples, "{}: {missed} of {samples} missed", e.text);
        }
    }
}

/// The integrals over the visible directions of 1, x, y, z, x^2, y^2, z^2, of w^2 and w, estimated
/// two ways.
#[derive(Default)]
struct Moments {
    sum: [f64; 7],
    squares: [f64; 7],
    n: f64,
}

impl Moments {
    fn add(&mut self, w: Vec3, weight: f64) {
        let [x, y, z] = w.as_dvec3().to_array();
        for (i, f) in [1.0, x, y, z, x * x, y * y, z * z].into_iter().enumerate() {
            self.sum[i] += f * weight;
            self.squares[i] += (f * weight) * (f * weight);
        }
    }

    fn mean_and_variance(&self, i: usize) -> (f64, f64) {
        let mean = self.sum[i] / self.n;
        (mean, (self.squares[i] / self.n - mean * mean).max(0.0) / self.n)
    }
}

/// The largest difference, in standard deviations, between the integrals by [`Shape::sample`], whose
/// pdf is multiplied by `bias`, and those by uniform directions.
fn largest_z(shape: &Shape, from: Vec3, reach: f32, n: usize, bias: f64) -> f64 {
    let mut random = Random(12);
    let (mut sampled, mut uniform) = (Moments::default(), Moments::default());
    for _ in 0..n {
        if let Some(s) = shape.sample(from, random.square()) {
            let wi = (s.p - from).normalize();
            let tolerance = 1e-4 * reach / wi.dot(s.ng).abs().max(1e-3);
            // Only the nearest hit is seen.
            if hit_at(shape, from, wi, s.p, tolerance).is_some_and(|(i, _)| i == 0) {
                sampled.add(wi, 1.0 / (f64::from(s.pdf) * bias));
            }
        }
        let w = random.direction();
        if shape.intersect(&Ray::new(from, w)).is_some() {
            uniform.add(w, 4.0 * std::f64::consts::PI);
        }
    }
    (sampled.n, uniform.n) = (n as f64, n as f64);
    let z = |i: usize| {
        let ((a, va), (b, vb)) = (sampled.mean_and_variance(i), uniform.mean_and_variance(i));
        (a - b).abs() / (va + vb).sqrt().max(1e-4 * b.abs()).max(1e-30)
    };
    (0..7).map(z).fold(0.0, f64::max)
}

#[test]
fn samples_integrate_to_the_solid_angle_that_is_seen() {
    for e in bounded() {
        for from in viewpoints(&e, &mut Random(13)).into_iter().take(4) {
            let z = largest_z(&e.shape, from, (from - e.center).length() + e.size, 20_000, 1.0);
            assert!(z < 4.5, "{}: {z} standard deviations from {from}", e.text);
        }
    }
}

#[test]
fn the_test_of_integrals_rejects_a_bias_of_one_percent() {
    let quad = shape("quad = { corners = [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]] }");
    let from = Vec3::new(0.1, 0.2, 0.0);
    assert!(largest_z(&quad, from, 1.0, 1_000_000, 1.0) < 4.5);
    assert!(largest_z(&quad, from, 1.0, 1_000_000, 1.01) > 4.5);
}

#[test]
fn a_sphere_is_sampled_soundly_however_much_of_the_view_it_fills() {
    for distance in [1.0_f32.next_up(), 1.0 + 1e-5, 1.1, 1e2, 1e4, 1e7] {
        let sphere = shape("sphere = { radius = 1 }");
        let from = Vec3::new(0.0, 0.6, 0.8) * distance;
        let (d, mut random) = (from.as_dvec3().length(), Random(14));
        let s2 = 1.0 / (d * d);
        let expected = 1.0 / (std::f64::consts::TAU * s2 / (1.0 + (1.0 - s2).max(0.0).sqrt()));
        // A point of the surface, which rounding may have put outside, sees the inside too.
        let is_outside = d > 1.0 + 2e-6;
        let mut seen_from_front = 0;
        for _ in 0..1000 {
            let s = sphere.sample(from, random.square()).unwrap();
            assert!((s.p.length() - 1.0).abs() < 1e-6);
            if is_outside {
                assert!(
                    (f64::from(s.pdf) / expected - 1.0).abs() < 1e-5,
                    "{distance}: {}",
                    s.pdf
                );
            }
            seen_from_front += usize::from((from - s.p).dot(s.ng) >= -1e-6 * d as f32);
        }
        assert!(!is_outside || seen_from_front == 1000, "{distance}: {seen_from_front}");
    }
}

#[test]
fn samples_from_the_surface_itself_are_sound_or_absent() {
    for e in bounded() {
        let mut random = Random(16);
        let bounds = e.shape.bounds();
        let mut places: Vec<Vec3> = (0..8).map(|i| bounds.corner(i)).collect();
        places.push(e.center);
        places.extend((0..50).filter_map(|_| e.shape.sample(e.center + e.size, random.square()).map(|s| s.p)));
        for from in places {
            for _ in 0..50 {
                if let Some(s) = e.shape.sample(from, random.square()) {
                    assert!(s.p.is_finite() && s.ng.is_finite(), "{}: {s:?}", e.text);
                    assert!(s.pdf > 0.0 && s.pdf.is_finite(), "{}: {s:?}", e.text);
                }
            }
        }
    }
}

#[test]
fn flat_shapes_are_not_seen_from_their_own_plane() {
    for text in [
        "quad = { corners = [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]] }",
        "quad = { corners = [[0, 0, 0], [1, 0, 3], [3, 0, 3], [3, 0, 0]] }",
        "disk = { radius = 1 }",
    ] {
        for from in [Vec3::ZERO, Vec3::new(0.25, 0.0, 0.5), Vec3::X * 9.0] {
            assert_eq!(shape(text).sample(from, Random(17).square()), None, "{text}");
        }
    }
}

#[test]
fn endless_shapes_are_not_sampled() {
    for e in all().iter().filter(|e| !e.shape.bounds().is_finite()) {
        assert_eq!(e.shape.sample(Vec3::ONE, Random(15).square()), None);
        assert_eq!(e.shape.area(), f32::INFINITY);
    }
}
