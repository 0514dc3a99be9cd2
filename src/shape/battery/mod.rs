//! Properties of every shape: a kind gets these tests by its examples.

mod bad_values;
mod block;
mod examples;
mod flat;
mod light;
mod round;
mod tessellation;

pub(super) use examples::Random;
use examples::{Example, all, bounded, hits};

use super::ShapeDesc;
use crate::math::{Ray, Vec3, float::offset_origins};

#[test]
fn every_kind_has_an_example() {
    let examples = all();
    // A mesh is compiled to triangles.
    for name in ShapeDesc::NAMES.iter().filter(|name| **name != "mesh") {
        assert!(examples.iter().any(|e| e.name == *name), "no example of {name}");
    }
}

/// Returns the number of random rays that hit, after `check` of each hit.
fn try_rays(e: &Example, random: &mut Random, mut check: impl FnMut(&Ray, &super::ShapeHit)) -> usize {
    let mut count = 0;
    for distance in [0.3, 2.0, 50.0, 1e5] {
        for _ in 0..1000 {
            for (ray, hit) in hits(&e.shape, &e.ray(random, distance)) {
                count += 1;
                check(&ray, &hit);
            }
        }
    }
    count
}

#[test]
fn bounds_hold_every_hit() {
    for e in all() {
        let bounds = e.shape.bounds();
        let count = try_rays(&e, &mut Random(1), |ray, hit| {
            let s = e.shape.surface(ray, hit);
            let inside = s.p.cmpge(bounds.min).all() && s.p.cmple(bounds.max).all();
            assert!(inside, "{}: {} in {bounds:?}", e.text, s.p);
        });
        assert!(count > 300, "{}: {count} hits", e.text);
    }
}

#[test]
fn surfaces_lie_where_the_ray_is() {
    for e in all() {
        try_rays(&e, &mut Random(2), |ray, hit| {
            let s = e.shape.surface(ray, hit);
            let at = ray.o.as_dvec3() + ray.d.as_dvec3() * f64::from(hit.t);
            // What rounding of t leaves, and, for the edge tests in single precision, of the
            // origin.
            let cos = ray.d.normalize().dot(s.ng).abs();
            let reach = (ray.o - s.p).length();
            let bound = 8.0 * f32::EPSILON * (reach + s.p.length() + e.size) / cos.max(1e-3);
            let off = (at - s.p.as_dvec3()).length() as f32;
            assert!(off <= bound, "{}: {off} > {bound}, {ray:?} {hit:?}", e.text);
        });
    }
}

#[test]
fn hits_lie_after_tmin_and_not_after_tmax() {
    for e in all() {
        try_rays(&e, &mut Random(3), |ray, hit| {
            assert!(hit.t > ray.tmin && hit.t <= ray.tmax && hit.t.is_finite());
            let cut = |tmin: f32, tmax: f32| e.shape.intersect(&Ray { tmin, tmax, ..*ray });
            assert_eq!(cut(ray.tmin, hit.t), Some(*hit), "{}: tmax is inclusive", e.text);
            assert_eq!(cut(ray.tmin, hit.t.next_down()), None, "{}: nearest", e.text);
            assert_ne!(cut(hit.t, f32::INFINITY), Some(*hit), "{}: tmin is exclusive", e.text);
        });
    }
}

#[test]
fn broken_rays_hit_nothing() {
    for e in all() {
        for bad in [Vec3::NAN, Vec3::new(1.0, f32::NAN, 0.0)] {
            assert_eq!(e.shape.intersect(&Ray::new(bad, Vec3::X)), None, "{}", e.text);
            assert_eq!(
                e.shape.intersect(&Ray::new(e.center + 9.0 * e.size, bad)),
                None,
                "{}",
                e.text
            );
        }
        let still = Ray::new(e.center, Vec3::ZERO);
        assert_eq!(e.shape.intersect(&still), None, "{}", e.text);
    }
}

#[test]
fn normals_are_unit_and_derivatives_lie_across_them() {
    for e in all() {
        try_rays(&e, &mut Random(4), |ray, hit| {
            let s = e.shape.surface(ray, hit);
            assert!((s.ng.length() - 1.0).abs() < 1e-6, "{}: {}", e.text, s.ng);
            assert!(s.dpdu.is_finite() && s.dpdv.is_finite() && s.uv.is_finite());
            if s.dpdu != Vec3::ZERO && s.dpdv != Vec3::ZERO {
                let (u, v) = (s.dpdu.normalize(), s.dpdv.normalize());
                assert!(
                    u.dot(s.ng).abs() < 1e-5 && v.dot(s.ng).abs() < 1e-5,
                    "{}: {s:?}",
                    e.text
                );
                assert!(u.cross(v).length() > 1e-3, "{}: {s:?}", e.text);
            }
        });
    }
}

#[test]
fn derivatives_tell_how_the_point_moves_with_uv() {
    for e in all() {
        let mut random = Random(5);
        let mut tried = 0;
        for _ in 0..2000 {
            let ray = e.ray(&mut random, 3.0);
            let aside = random.direction() * ray.d.length() * 3e-4;
            let moved = Ray {
                d: ray.d + aside,
                ..ray
            };
            let (Some(h0), Some(h1)) = (e.shape.intersect(&ray), e.shape.intersect(&moved)) else {
                continue;
            };
            let (s0, s1) = (e.shape.surface(&ray, &h0), e.shape.surface(&moved, &h1));
            let dp = s1.p - s0.p;
            let duv = s1.uv - s0.uv;
            // Near a pole the derivative itself turns too fast for a difference.
            let near_pole = s0.dpdu != s1.dpdu && dp.length() > 0.005 * s0.dpdu.length().min(s1.dpdu.length());
            let grazes = ray.d.normalize().dot(s0.ng).abs() < 0.2;
            let seam = duv.x.abs() > 0.5 || h0.u != h1.u || s0.ng.dot(s1.ng) < 0.99;
            if near_pole || grazes || seam {
                continue;
            }
            tried += 1;
            let expected = (s0.dpdu + s1.dpdu) * 0.5 * duv.x + (s0.dpdv + s1.dpdv) * 0.5 * duv.y;
            let rounding = 4.0 * f32::EPSILON * (s0.p.length() + e.size + (s0.dpdu + s0.dpdv).length());
            let off = (expected - dp).length();
            assert!(
                off <= 1e-3 * dp.length() + rounding,
                "{}: {expected} is not {dp}",
                e.text
            );
        }
        assert!(tried > 60, "{}: {tried} tried", e.text);
    }
}

#[test]
fn spawned_rays_never_meet_the_surface_they_leave() {
    for e in all() {
        let mut random = Random(6);
        let mut spawned = 0;
        while spawned < 1000 {
            let distance = [0.3, 2.0, 50.0, 1e5][random.0 as usize % 4];
            for (ray, hit) in hits(&e.shape, &e.ray(&mut random, distance)) {
                let s = e.shape.surface(&ray, &hit);
                // Half of them graze the surface.
                let w = random.direction();
                let flat = (w - s.ng * w.dot(s.ng)).normalize_or(s.ng.any_orthonormal_vector());
                let cos = if spawned % 2 == 0 {
                    w.dot(s.ng)
                } else {
                    1e-6 * random.next()
                };
                for side in [1.0, -1.0] {
                    let w = flat + s.ng * cos.abs() * side;
                    let [above, below] = offset_origins(s.p, s.p_error, s.ng);
                    let o = if w.dot(s.ng) < 0.0 { below } else { above };
                    let again = e.shape.intersect(&Ray::new(o, w));
                    if outward(&s.ng, &w) || e.shape.flat_normal().is_some() {
                        assert_eq!(again, None, "{}: from {o} along {w}, at {s:?}", e.text);
                    } else if let Some(again) = again.filter(|_| cos.abs() > 1e-3) {
                        let leap = again.t * w.length();
                        assert!(leap > 4.0 * s.p_error.max_element(), "{}: {leap} at {s:?}", e.text);
                    }
                }
                spawned += 1;
            }
        }
    }
}

fn outward(ng: &Vec3, w: &Vec3) -> bool {
    w.dot(*ng) >= 0.0
}

/// A flat emitter that does not say so has more noise than it needs.
#[test]
fn a_shape_of_one_normal_says_so() {
    for e in all() {
        let mut normals = Vec::new();
        try_rays(&e, &mut Random(11), |ray, hit| {
            normals.push(e.shape.surface(ray, hit).ng)
        });
        let is_normal = |n: Vec3| normals.iter().all(|other| n.distance(*other) < 1e-5);
        match e.shape.flat_normal() {
            Some(n) => assert!(is_normal(n), "{}: {n} is not its normal everywhere", e.text),
            None => assert!(!is_normal(normals[0]), "{}: flat, without a `flat_normal`", e.text),
        }
    }
}

#[test]
fn area_is_what_random_lines_cross() {
    // Cauchy and Crofton: lines uniform in a ball of radius r cross a surface A / (2 pi r^2) times
    // in the mean. Of each crossing one of the line's two directions meets the front.
    const LINES: usize = 60_000;
    for e in bounded() {
        let mut random = Random(7);
        let r = f64::from(e.size) * 1.01;
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..LINES {
            let w = random.direction();
            let (s, t) = w.any_orthonormal_pair();
            let phi = random.next() * std::f32::consts::TAU;
            let across = (s * libm::cosf(phi) + t * libm::sinf(phi)) * (random.next().sqrt() * r as f32);
            let mut fronts = 0.0;
            for w in [w, -w] {
                let line = Ray::new(e.center + across - w * (2.0 * r as f32), w);
                fronts += hits(&e.shape, &line)
                    .iter()
                    .filter(|(ray, hit)| e.shape.surface(ray, hit).ng.dot(w) < 0.0)
                    .count() as f64;
            }
            sum += fronts;
            squares += fronts * fronts;
        }
        let n = LINES as f64;
        let (mean, scale) = (sum / n, std::f64::consts::TAU * r * r);
        let sigma = ((squares / n - mean * mean) / n).sqrt();
        let (found, area) = (mean * scale, f64::from(e.shape.area()));
        assert!(
            (found - area).abs() < 4.5 * sigma * scale,
            "{}: {found} is not {area}",
            e.text
        );
    }
}
