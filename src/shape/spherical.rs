//! Points of a triangle as seen from a point: directions that are uniform by solid angle, or points by area.
//!
//! Seen from nearby, points that are uniform by area crowd where the triangle is far away or seen
//! edge-on, and the density of their directions differs by orders of magnitude; that of uniform
//! directions does not. What is small to the eye is left to the area: there the two are the same,
//! and that one is cheaper.
//!
//! Source: Arvo, "Stratified Sampling of Spherical Triangles", SIGGRAPH 1995,
//! doi:10.1145/218380.218500, in the form of Peters, "BRDF Importance Sampling for Polygonal Lights",
//! ACM Transactions on Graphics 40(4), 2021, doi:10.1145/3450626.3459672; for the solid angle Van Oosterom and Strackee, "The Solid
//! Angle of a Plane Triangle", IEEE Trans. Biomed. Eng. 30(2), 1983, doi:10.1109/TBME.1983.325207.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{
    block::vector,
    numeric::solid_angle_pdf,
    sampled::{SampledKind, SampledPoint},
    triangle::{self, TrianglePoint},
};
use crate::math::{Vec2, Vec3, trig};

/// A triangle whose area over the square of the distance to its nearest corner is not larger is
/// small to the eye.
const SMALL: f64 = 0.02;
/// Solid angles beyond these, in sr, are those of triangles seen nearly edge-on, or from nearly
/// within: their angles are lost in rounding.
const SOLID_ANGLES: std::ops::Range<f64> = 1e-3..TAU - 1e-3;

/// A triangle as seen from a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenTriangle {
    /// The corners, relative to the point.
    corners: [DVec3; 3],
    /// The unit directions to them.
    unit: [DVec3; 3],
    /// The volume that the directions span, and 1 + the cosines between them: half the solid angle is the angle of this point.
    volume: f64,
    cosines: f64,
    /// In sr.
    pub solid_angle: f64,
    /// Whether directions are chosen uniformly; else, points by area.
    pub is_large: bool,
}

impl SeenTriangle {
    #[inline(always)]
    pub fn new(corners: [Vec3; 3], from: Vec3) -> Self {
        let from = from.as_dvec3();
        let [a, b, c] = corners;
        let (to_a, to_b, to_c) = (a.as_dvec3() - from, b.as_dvec3() - from, c.as_dvec3() - from);
        let nearest2 = to_a
            .length_squared()
            .min(to_b.length_squared())
            .min(to_c.length_squared());
        let twice_area2 = (to_b - to_a).cross(to_c - to_a).length_squared();
        let is_large = twice_area2 > (2.0 * SMALL * nearest2) * (2.0 * SMALL * nearest2);
        let (a, b, c) = (to_a / to_a.length(), to_b / to_b.length(), to_c / to_c.length());
        let volume = a.dot(b.cross(c)).abs();
        let cosines = 1.0 + a.dot(b) + b.dot(c) + c.dot(a);
        let solid_angle = 2.0 * trig::angle_above(volume, cosines);
        Self {
            corners: [to_a, to_b, to_c],
            unit: [a, b, c],
            volume,
            cosines,
            solid_angle,
            is_large: is_large & (nearest2 > 0.0) & SOLID_ANGLES.contains(&solid_angle),
        }
    }

    /// The weights of b and c of the point in a direction chosen uniformly, from two uniform numbers in `[0, 1)`.
    #[inline(always)]
    pub fn sample(&self, u: Vec2) -> Vec2 {
        let [a, b, c] = self.unit;
        // A third corner on the side from a to c, such that the part of the triangle is the wanted one: the mirror image of a.
        let (sin, cos) = trig::sin_cos_turn(f64::from(u.x) * self.solid_angle * (0.5 / TAU));
        let middle = a * (self.volume * cos - (self.cosines - 1.0 - a.dot(b)) * sin) + c * ((1.0 + a.dot(b)) * sin);
        let corner = middle * (2.0 * a.dot(middle) / middle.length_squared()) - a;
        // A direction on the way from b to it.
        let end = corner.dot(b);
        let z = 1.0 - f64::from(u.y) * (1.0 - end);
        let part = ((1.0 - z * z) / (1.0 - end * end)).sqrt();
        let part = if part.is_finite() { part } else { u.y.into() };
        self.weights_along(b * (z - part * end) + corner * part)
    }

    /// The weights of b and c of the point of the triangle along `w`, or of one nearby where rounding
    /// says that it is beside.
    #[inline(always)]
    fn weights_along(&self, w: DVec3) -> Vec2 {
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        let normal = w.cross(ac);
        let det = ab.dot(normal);
        let (x, y) = (-a.dot(normal) / det, w.dot(ab.cross(a)) / det);
        let x = if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 };
        let y = if y.is_finite() { y.clamp(0.0, 1.0) } else { 0.0 };
        let sum = (x + y).max(1.0);
        Vec2::new((x / sum) as f32, (y / sum) as f32)
    }
}

/// The weights of b and c of a point as seen from `from`, from two uniform numbers in `[0, 1)`, and
/// the density of its direction in sr^-1, 0 where it is seen edge-on or there is no area. Uniform
/// by solid angle where the triangle is large to the eye, else by area.
#[inline(always)]
pub fn sample(corners: [Vec3; 3], from: Vec3, u: Vec2) -> (Vec2, f32) {
    let seen = SeenTriangle::new(corners, from);
    let (by_angle, by_area) = (seen.sample(u), triangle::sample_barycentric(u));
    let weights = Vec2::new(
        if seen.is_large { by_angle.x } else { by_area.x },
        if seen.is_large { by_angle.y } else { by_area.y },
    );
    (weights, pdf_of(&seen, corners, from, weights))
}

/// The density of [`sample`] to choose the point that the hit `u`, `v` is, in sr^-1 as seen from
/// `from`.
pub fn pdf(corners: [Vec3; 3], from: Vec3, u: f32, v: f32) -> f32 {
    pdf_of(&SeenTriangle::new(corners, from), corners, from, Vec2::new(u, v))
}

#[inline(always)]
fn pdf_of(seen: &SeenTriangle, corners: [Vec3; 3], from: Vec3, weights: Vec2) -> f32 {
    // The length of this normal is twice the area.
    let by_area = solid_angle_pdf(
        2.0,
        from.as_dvec3(),
        triangle::point(corners, weights),
        triangle::normal_times_area(corners),
    );
    if seen.is_large {
        (1.0 / seen.solid_angle) as f32
    } else {
        by_area
    }
}

/// A triangle that emits.
impl SampledKind<9> for [Vec3; 3] {
    #[inline(always)]
    fn sample_numbers(&self) -> [f64; 9] {
        let [a, b, c] = *self;
        [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z].map(f64::from)
    }

    #[inline(always)]
    fn sample_by(numbers: &[f64; 9], from: Vec3, u: Vec2) -> SampledPoint {
        let corners = [
            vector(numbers, 0).as_vec3(),
            vector(numbers, 3).as_vec3(),
            vector(numbers, 6).as_vec3(),
        ];
        let (weights, pdf) = sample(corners, from, u);
        let (TrianglePoint { p, p_error, ng }, is_known) = triangle::point_in_f32(corners, weights.x, weights.y);
        SampledPoint {
            p,
            p_error,
            ng,
            pdf,
            is_known,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash;

    fn solid_angle(corners: [Vec3; 3], from: Vec3) -> Option<f64> {
        let seen = SeenTriangle::new(corners, from);
        seen.is_large.then_some(seen.solid_angle)
    }

    fn by_angle(corners: [Vec3; 3], from: Vec3, u: Vec2) -> Option<(Vec2, f64)> {
        Some((SeenTriangle::new(corners, from).sample(u), solid_angle(corners, from)?))
    }

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
                let (weights, same) = by_angle(CORNERS, from, numbers(i)).expect("large enough");
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
        let corner = |u: Vec2| triangle::point(CORNERS, by_angle(CORNERS, from, u).expect("large").0).as_vec3();
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
            let (weights, angle) = by_angle(corners, from, u).expect("large");
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
