//! Directions towards a triangle, chosen uniformly by solid angle.
//!
//! Seen from nearby, points that are uniform by area crowd where the triangle is far away or seen
//! edge-on, and the density of their directions differs by orders of magnitude; that of uniform
//! directions does not. What is small to the eye is left to the area: there the two are the same,
//! and that one is cheaper.
//!
//! Source: Arvo, "Stratified Sampling of Spherical Triangles", SIGGRAPH 1995,
//! doi:10.1145/218380.218500; for the solid angle Van Oosterom and Strackee, "The Solid Angle of a
//! Plane Triangle", IEEE Trans. Biomed. Eng. 30(2), 1983, doi:10.1109/TBME.1983.325207.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::math::{Vec2, Vec3};

/// A triangle whose area over the square of the distance to its nearest corner is not larger is
/// small to the eye.
const SMALL: f64 = 0.02;
/// Solid angles beyond these, in sr, are those of triangles seen nearly edge-on, or from nearly
/// within: their angles are lost in rounding.
const SOLID_ANGLES: std::ops::Range<f64> = 1e-3..TAU - 1e-3;

/// The unit directions to the corners.
fn directions(corners: [Vec3; 3], from: Vec3) -> Option<[DVec3; 3]> {
    let from = from.as_dvec3();
    let [a, b, c] = corners.map(|p| p.as_dvec3() - from);
    let nearest2 = a.length_squared().min(b.length_squared()).min(c.length_squared());
    let twice_area2 = (b - a).cross(c - a).length_squared();
    let large = twice_area2 > (2.0 * SMALL * nearest2) * (2.0 * SMALL * nearest2);
    (large && nearest2 > 0.0).then(|| [a, b, c].map(DVec3::normalize))
}

/// The solid angle of the triangle as seen from `from`, in sr, where its directions are chosen
/// uniformly; `None` where its points are chosen by area instead.
#[inline]
pub fn solid_angle(corners: [Vec3; 3], from: Vec3) -> Option<f64> {
    solid_angle_of(&directions(corners, from)?)
}

fn solid_angle_of([a, b, c]: &[DVec3; 3]) -> Option<f64> {
    let half_tan = (a.dot(b.cross(*c)).abs(), 1.0 + a.dot(*b) + b.dot(*c) + c.dot(*a));
    let angle = 2.0 * libm::atan2(half_tan.0, half_tan.1);
    SOLID_ANGLES.contains(&angle).then_some(angle)
}

/// The part of `v` that is at a right angle to the unit vector `to`, unit.
fn across(v: DVec3, to: DVec3) -> DVec3 {
    (v - to * v.dot(to)).normalize()
}

/// The weights of b and c of the point in a direction chosen uniformly, from two uniform numbers in
/// `[0, 1)`, and the solid angle; `None` as [`solid_angle`].
pub fn sample(corners: [Vec3; 3], from: Vec3, u: Vec2) -> Option<(Vec2, f64)> {
    let unit = directions(corners, from)?;
    let angle = solid_angle_of(&unit)?;
    let [a, b, c] = unit;
    // The angle at a, between the planes of its two sides.
    let (ab, ac) = (across(b, a), across(c, a));
    let cos_alpha = ab.dot(ac).clamp(-1.0, 1.0);
    let sin_alpha = ab.cross(ac).length();
    let alpha = libm::atan2(sin_alpha, cos_alpha);
    // A third corner on the side from a to c, such that the part of the triangle is the wanted one.
    let part = f64::from(u.x) * angle;
    let (s, t) = (libm::sin(part - alpha), libm::cos(part - alpha));
    let p = t - cos_alpha;
    let q = s + sin_alpha * a.dot(b);
    let cos_side = ((q * t - p * s) * cos_alpha - q) / ((q * s + p * t) * sin_alpha);
    let cos_side = if cos_side.is_finite() {
        cos_side.clamp(-1.0, 1.0)
    } else {
        1.0
    };
    let corner = a * cos_side + ac * (1.0 - cos_side * cos_side).sqrt();
    // A direction on the way from b to it.
    let z = 1.0 - f64::from(u.y) * (1.0 - corner.dot(b));
    let side = (corner - b * corner.dot(b)).normalize_or_zero();
    let w = b * z + side * (1.0 - z * z).max(0.0).sqrt();
    Some((weights_along(corners, from, w), angle))
}

/// The weights of b and c of the point of the triangle along `w`, or of one nearby where rounding
/// says that it is beside.
fn weights_along(corners: [Vec3; 3], from: Vec3, w: DVec3) -> Vec2 {
    let [a, b, c] = corners.map(|p| p.as_dvec3() - from.as_dvec3());
    let (ab, ac) = (b - a, c - a);
    let normal = w.cross(ac);
    let det = ab.dot(normal);
    let v = (-a).cross(ab);
    let weights = [-a.dot(normal) / det, w.dot(v) / det].map(|x| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 });
    let sum = (weights[0] + weights[1]).max(1.0);
    Vec2::new((weights[0] / sum) as f32, (weights[1] / sum) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{math::hash, shape::triangle};

    fn numbers(i: u32) -> Vec2 {
        let [x, y, ..] = hash::pcg4d([i, 3, 5, 7]).map(|v| (v >> 8) as f32 / (1 << 24) as f32);
        Vec2::new(x, y)
    }

    /// A triangle and places near to it, far from it, and beside it.
    const CORNERS: [Vec3; 3] = [
        Vec3::new(-1.0, 0.0, -1.0),
        Vec3::new(2.0, 0.0, 0.5),
        Vec3::new(-0.5, 0.0, 1.5),
    ];
    const PLACES: [Vec3; 6] = [
        Vec3::new(0.0, 0.3, 0.2),
        Vec3::new(0.1, -1.0, 0.0),
        Vec3::new(3.0, 0.5, 1.0),
        Vec3::new(0.0, 0.01, 0.0),
        Vec3::new(-1.2, 0.2, -1.1),
        Vec3::new(1.0, 4.0, 0.0),
    ];

    #[test]
    fn directions_are_uniform_in_the_triangle_as_counted_by_area() {
        // What falls into each of its halves, by directions and by an integral over the area.
        for from in PLACES {
            let angle = solid_angle(CORNERS, from).expect("large enough");
            let n = 60_000;
            let (mut counts, mut integrals) = ([0.0_f64; 3], [0.0_f64; 3]);
            for i in 0..n {
                let (weights, same) = sample(CORNERS, from, numbers(i)).expect("large enough");
                assert_eq!(same, angle);
                assert!(weights.x >= 0.0 && weights.y >= 0.0 && weights.x + weights.y <= 1.0 + 1e-6);
                let nearest = |w: Vec2| {
                    let all = [1.0 - w.x - w.y, w.x, w.y];
                    (0..3).max_by(|i, j| all[*i].total_cmp(&all[*j])).expect("three")
                };
                counts[nearest(weights)] += angle / f64::from(n);
                // Evenly by area.
                let at = Vec2::new((i % 245) as f32 + 0.5, (i / 245) as f32 + 0.5) / 245.0;
                let weights = triangle::sample_barycentric(at);
                let to = triangle::point(CORNERS, weights) - from.as_dvec3();
                let cos = to.normalize().y.abs();
                integrals[nearest(weights)] += triangle::area(CORNERS) * cos / to.length_squared() / f64::from(n);
            }
            for (count, integral) in counts.iter().zip(integrals) {
                let error = (angle * angle / f64::from(n)).sqrt();
                // Near to the triangle the integral over its area is the worse one.
                let slack = if from.y.abs() < 0.1 { 0.3 } else { 0.02 };
                assert!(
                    (count - integral).abs() < 4.0 * error + slack,
                    "{from}: {counts:?} {integrals:?}"
                );
            }
        }
    }

    #[test]
    fn the_point_lies_in_the_direction_that_was_chosen() {
        // The four corners of the square of numbers lead to corners of the triangle.
        let from = PLACES[0];
        let corner = |u: Vec2| triangle::point(CORNERS, sample(CORNERS, from, u).expect("large").0).as_vec3();
        assert!((corner(Vec2::new(0.3, 0.0)) - CORNERS[1]).length() < 1e-3);
        assert!((corner(Vec2::new(0.0, 1.0)) - CORNERS[0]).length() < 1e-3);
        assert!((corner(Vec2::new(1.0, 1.0)) - CORNERS[2]).length() < 1e-3);
    }

    #[test]
    fn an_octant_is_an_eighth_of_all_directions() {
        let angle = solid_angle([Vec3::X, Vec3::Y, Vec3::Z], Vec3::ZERO).expect("large");
        assert!((angle - TAU / 4.0).abs() < 1e-12);
    }

    #[test]
    fn small_needle_like_and_edge_on_triangles_are_left_to_the_area() {
        assert_eq!(solid_angle(CORNERS, Vec3::new(0.0, 60.0, 0.0)), None);
        assert_eq!(solid_angle(CORNERS, Vec3::new(5.0, 0.0, 0.0)), None);
        assert_eq!(solid_angle([Vec3::X, Vec3::X * 2.0, Vec3::X * 3.0], Vec3::Y), None);
        assert_eq!(solid_angle(CORNERS, CORNERS[1]), None);
    }

    #[test]
    fn near_to_a_large_triangle_irradiance_has_less_variance_than_by_area() {
        // Samples of the cosine over the density, from a floor under a triangle that hangs over it
        // aslant.
        let (corners, from) = (
            [
                Vec3::new(-4.0, 0.3, -1.0),
                Vec3::new(4.0, 0.6, -1.0),
                Vec3::new(0.0, 3.0, 5.0),
            ],
            Vec3::ZERO,
        );
        let variance = |sample: &dyn Fn(Vec2) -> (f64, f64)| {
            let n = 20_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for i in 0..n {
                let (cos, pdf) = sample(numbers(i));
                sum += cos.max(0.0) / pdf / f64::from(n);
                squares += (cos.max(0.0) / pdf).powi(2) / f64::from(n);
            }
            (sum, squares - sum * sum)
        };
        let up = |weights: Vec2| triangle::point(corners, weights).normalize().y;
        let (by_angle, noise) = variance(&|u| {
            let (weights, angle) = sample(corners, from, u).expect("large");
            (up(weights), 1.0 / angle)
        });
        let (by_area, more) = variance(&|u| {
            let weights = triangle::sample_barycentric(u);
            let to = triangle::point(corners, weights);
            let [a, b, c] = corners.map(|p| p.as_dvec3());
            let n = (b - a).cross(c - a).normalize();
            let pdf = to.length_squared() / n.dot(to.normalize()).abs() / triangle::area(corners);
            (up(weights), pdf)
        });
        assert!(
            (by_angle - by_area).abs() < 4.0 * ((noise + more) / 20_000.0).sqrt(),
            "{by_angle} {by_area}"
        );
        assert!(noise < 0.3 * more, "{noise} {more}");
    }
}
