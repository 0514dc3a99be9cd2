//! Directions towards a rectangle, chosen uniformly by solid angle.
//!
//! Source: Urena, Fajardo, King, "An Area-Preserving Parametrization for Spherical Rectangles",
//! Computer Graphics Forum 32(4), 2013, doi:10.1111/cgf.12151.

use std::f64::consts::PI;

use super::numeric::solid_angle_pdf;
use crate::math::{DVec3, Vec2};

/// Below this solid angle, in sr, a rectangle is taken by area: its spherical angles no longer tell
/// it from a right one with digits to spare, and the two ways hardly differ.
const SMALLEST_SOLID_ANGLE: f64 = 1e-4;

/// Below this size, as its diagonal over the distance of a corner, a rectangle is taken by area: the two ways hardly differ,
/// and this one takes a tenth of the time.
const SMALLEST_SIZE: f64 = 0.04;

/// A rectangle as seen from a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenRectangle {
    from: DVec3,
    corner: DVec3,
    edges: [DVec3; 2],
    normal: DVec3,
    spherical: Option<Spherical>,
}

/// The rectangle projected onto the unit sphere around the observer, in a frame along its edges, z
/// towards the observer.
#[derive(Clone, Copy, Debug)]
struct Spherical {
    frame: [DVec3; 3],
    x: [f64; 2],
    y: [f64; 2],
    z: f64,
    b: [f64; 2],
    /// The sum of its spherical angles at x0.
    angle: f64,
    solid_angle: f64,
}

impl SeenRectangle {
    /// The rectangle that `edges`, perpendicular to each other, span at `corner`.
    pub fn new(from: DVec3, corner: DVec3, edges: [DVec3; 2]) -> Self {
        let normal = edges[0].cross(edges[1]).normalize_or(DVec3::Y);
        Self {
            from,
            corner,
            edges,
            normal,
            spherical: Spherical::new(from, corner, edges, normal),
        }
    }

    fn area(&self) -> f64 {
        self.edges[0].cross(self.edges[1]).length()
    }

    /// Its solid angle in sr, exact unless it is very small.
    pub fn solid_angle(&self) -> f64 {
        if let Some(s) = self.spherical {
            return s.solid_angle;
        }
        let center = self.corner + (self.edges[0] + self.edges[1]) * 0.5;
        let to = center - self.from;
        let distance2 = to.length_squared();
        let estimate = self.area() * self.normal.dot(to).abs() / (distance2 * distance2.sqrt());
        if estimate.is_finite() { estimate } else { 0.0 }
    }

    /// A point of it.
    pub fn sample(&self, u: f64, v: f64) -> DVec3 {
        match self.spherical {
            Some(s) => self.from + s.sample(u, v),
            None => self.corner + self.edges[0] * u + self.edges[1] * v,
        }
    }

    /// The density of [`SeenRectangle::sample`] at its point `p`, in sr^-1.
    pub fn pdf(&self, p: DVec3) -> f32 {
        match self.spherical {
            Some(s) => (1.0 / s.solid_angle) as f32,
            None => solid_angle_pdf(1.0 / self.area(), self.from, p, self.normal),
        }
    }

    /// The position of `p` on the rectangle, in lengths of its edges.
    pub fn uv(corner: DVec3, edges: [DVec3; 2], p: DVec3) -> Vec2 {
        let q = p - corner;
        let part = |e: DVec3| (q.dot(e) / e.length_squared()).clamp(0.0, 1.0) as f32;
        Vec2::new(part(edges[0]), part(edges[1]))
    }
}

impl Spherical {
    /// `None` where the solid angle is too small for its angles to tell, or seen edge-on.
    fn new(from: DVec3, corner: DVec3, edges: [DVec3; 2], normal: DVec3) -> Option<Self> {
        let size2 = edges[0].length_squared() + edges[1].length_squared();
        if size2 < SMALLEST_SIZE * SMALLEST_SIZE * (corner - from).length_squared() {
            return None;
        }
        let lengths = edges.map(DVec3::length);
        let (fx, fy) = (edges[0] / lengths[0], edges[1] / lengths[1]);
        let d = corner - from;
        let (z, fz) = if d.dot(normal) > 0.0 {
            (-d.dot(normal), -normal)
        } else {
            (d.dot(normal), normal)
        };
        if z == 0.0 {
            return None;
        }
        let (x0, y0) = (d.dot(fx), d.dot(fy));
        let (x, y) = ([x0, x0 + lengths[0]], [y0, y0 + lengths[1]]);
        // The z of the normals of the planes through the observer and each edge.
        let n = [-y[0], x[1], y[1], -x[0]].map(|v| v / (v * v + z * z).sqrt());
        // Of two neighbouring planes, the angle between them less a right one.
        let angle = |i: usize, j: usize| libm::asin(n[i] * n[j]);
        let angles = [angle(2, 3) + angle(3, 0), angle(0, 1) + angle(1, 2)];
        let solid_angle = angles[0] + angles[1];
        (solid_angle >= SMALLEST_SOLID_ANGLE).then_some(Self {
            frame: [fx, fy, fz],
            x,
            y,
            z,
            b: [n[0], n[2]],
            angle: PI + angles[0],
            solid_angle,
        })
    }

    /// From the observer to a point of the rectangle.
    fn sample(&self, u: f64, v: f64) -> DVec3 {
        let phi = u * self.solid_angle - self.angle;
        let (sin, cos) = (libm::sin(phi), libm::cos(phi));
        let f = (cos * self.b[0] - self.b[1]) / sin;
        let c = (1.0 / (f * f + self.b[0] * self.b[0]).sqrt())
            .copysign(f)
            .clamp(-1.0, 1.0);
        let x = -(c * self.z) / (1.0 - c * c).max(0.0).sqrt();
        // 0 / 0 where the observer is in the plane of the rectangle; clamp would hand NaN on.
        let x = if x.is_nan() {
            self.x[0]
        } else {
            x.clamp(self.x[0], self.x[1])
        };
        let d2 = x * x + self.z * self.z;
        let h = self.y.map(|y| y / (d2 + y * y).sqrt());
        let hv = h[0] + v * (h[1] - h[0]);
        let y = hv * (d2 / (1.0 - hv * hv)).sqrt();
        let y = if y.is_nan() {
            self.y[1]
        } else {
            y.clamp(self.y[0], self.y[1])
        };
        self.frame[0] * x + self.frame[1] * y + self.frame[2] * self.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_of_a_cube_fills_a_sixth_of_all_directions_from_its_middle() {
        let seen = SeenRectangle::new(
            DVec3::ZERO,
            DVec3::new(-1.0, -1.0, 1.0),
            [DVec3::X * 2.0, DVec3::Y * 2.0],
        );
        assert!((seen.solid_angle() - 4.0 * PI / 6.0).abs() < 1e-12);
    }

    #[test]
    fn solid_angle_of_a_far_rectangle_is_its_area_over_distance_squared() {
        for distance in [90.0, 110.0, 1e4] {
            let seen = SeenRectangle::new(DVec3::new(0.5, 0.5, distance), DVec3::ZERO, [DVec3::X, DVec3::Y]);
            let expected = 1.0 / (distance * distance);
            assert!((seen.solid_angle() / expected - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn points_are_uniform_by_solid_angle() {
        // A quarter of the numbers must fall on the quarter of the rectangle that sees as much as
        // the other three.
        let from = DVec3::new(0.3, -0.4, 0.5);
        let seen = SeenRectangle::new(from, DVec3::ZERO, [DVec3::X, DVec3::Y * 3.0]);
        let part = SeenRectangle::new(from, DVec3::ZERO, [DVec3::X * 0.6, DVec3::Y * 0.7]);
        let n = 300;
        let mut inside = 0;
        for i in 0..n * n {
            let p = seen.sample(
                (f64::from(i % n) + 0.5) / f64::from(n),
                (f64::from(i / n) + 0.5) / f64::from(n),
            );
            assert!(p.z.abs() < 1e-12 && p.x >= -1e-12 && p.x <= 1.0 + 1e-12 && p.y <= 3.0 + 1e-12);
            inside += i32::from(p.x < 0.6 && p.y < 0.7);
        }
        let found = f64::from(inside) / f64::from(n * n);
        assert!(
            (found - part.solid_angle() / seen.solid_angle()).abs() < 2e-3,
            "{found}"
        );
    }
}
