//! Directions towards a rectangle, chosen uniformly by solid angle, or by area where that is as good.
//!
//! Source: Urena, Fajardo, King, "An Area-Preserving Parametrization for Spherical Rectangles",
//! Computer Graphics Forum 32(4), 2013, doi:10.1111/cgf.12151.

use std::f64::consts::TAU;

use super::{
    block::vector,
    numeric::solid_angle_pdf,
    sampled::{SampledKind, SampledPoint},
};
use crate::math::{DVec2, DVec3, Vec2, Vec3, trig};

/// Below this solid angle, in sr, a rectangle is taken by area: its spherical angles no longer tell
/// it from a right one with digits to spare, and the two ways hardly differ.
const SMALLEST_SOLID_ANGLE: f64 = 1e-4;

/// Up to this ratio of the squared distances of its farthest and its nearest point, a rectangle is taken by area: that
/// hardly adds noise, and it takes a tenth of the time.
const MAX_SPREAD: f64 = 9.0;

/// A rectangle that is seen from many points.
#[derive(Clone, Copy, Debug)]
pub struct Rectangle {
    pub corner: DVec3,
    /// Perpendicular to each other.
    pub edges: [DVec3; 2],
    pub lengths: [f64; 2],
    /// Unit, the direction of the edges' cross product.
    pub normal: DVec3,
}

/// A rectangle as seen from a point.
#[derive(Clone, Copy, Debug)]
pub struct SeenRectangle {
    rectangle: Rectangle,
    from: DVec3,
    spherical: Option<Spherical>,
}

/// The rectangle projected onto the unit sphere around the observer, in a frame along its edges, z
/// along the normal.
#[derive(Clone, Copy, Debug)]
struct Spherical {
    x: [f64; 2],
    y: [f64; 2],
    /// Not 0; of either sign.
    z: f64,
    /// y and the distance from the x axis, of each edge along it.
    ridges: [DVec2; 2],
    /// Cosine and sine of the sum of the spherical angles at x0, less two right ones.
    turn: DVec2,
    solid_angle: f64,
}

/// The product of two complex numbers.
#[inline]
fn product(a: DVec2, b: DVec2) -> DVec2 {
    DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

/// The product of a complex number and the conjugate of another.
#[inline]
fn quotient(a: DVec2, b: DVec2) -> DVec2 {
    product(a, DVec2::new(b.x, -b.y))
}

impl Rectangle {
    #[inline(always)]
    pub fn area(&self) -> f64 {
        self.lengths[0] * self.lengths[1]
    }

    #[inline]
    pub fn seen_from(self, from: DVec3) -> SeenRectangle {
        SeenRectangle {
            rectangle: self,
            from,
            spherical: Spherical::new(from, &self),
        }
    }

    /// Its point at `u` and `v`, in lengths of its edges.
    #[inline(always)]
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        self.corner + self.edges[0] * u + self.edges[1] * v
    }

    /// Whether sampling by area is as good as by solid angle, as seen from a point.
    #[inline(always)]
    pub fn is_sampled_by_area(&self, from: DVec3) -> bool {
        let (x, y, z) = sides(from, self);
        let z2 = z * z;
        z2 + farthest2(x) + farthest2(y) <= MAX_SPREAD * (z2 + nearest2(x) + nearest2(y))
    }

    /// The density at its point `p` of a point chosen by area, in sr^-1 as seen from `from`.
    #[inline(always)]
    pub fn pdf_by_area(&self, from: DVec3, p: DVec3) -> f32 {
        solid_angle_pdf(1.0 / self.area(), from, p, self.normal)
    }

    /// The position of its point `p`, in lengths of its edges.
    pub fn uv(&self, p: DVec3) -> Vec2 {
        let q = p - self.corner;
        let part = |k: usize| (q.dot(self.edges[k]) / (self.lengths[k] * self.lengths[k])).clamp(0.0, 1.0) as f32;
        Vec2::new(part(0), part(1))
    }
}

impl SampledKind<14> for Rectangle {
    #[inline(always)]
    fn sample_numbers(&self) -> [f64; 14] {
        let (a, [e, f], n, [w, h]) = (self.corner, self.edges, self.normal, self.lengths);
        [a.x, a.y, a.z, e.x, e.y, e.z, f.x, f.y, f.z, n.x, n.y, n.z, w, h]
    }

    /// Samples by area; it is known where that is as good as by solid angle.
    #[inline(always)]
    fn sample_by(numbers: &[f64; 14], from: Vec3, u: Vec2) -> SampledPoint {
        let rectangle = Self {
            corner: vector(numbers, 0),
            edges: [vector(numbers, 3), vector(numbers, 6)],
            normal: vector(numbers, 9),
            lengths: [numbers[12], numbers[13]],
        };
        let from = from.as_dvec3();
        let p = rectangle.point(u.x.into(), u.y.into());
        let pdf = rectangle.pdf_by_area(from, p);
        SampledPoint {
            is_known: rectangle.is_sampled_by_area(from),
            ..SampledPoint::new(p.as_vec3(), rectangle.normal.as_vec3(), pdf)
        }
    }
}

impl SeenRectangle {
    /// Its solid angle in sr, exact unless it is very small.
    pub fn solid_angle(&self) -> f64 {
        if let Some(s) = self.spherical.or_else(|| Spherical::whole(self.from, &self.rectangle)) {
            return s.solid_angle;
        }
        let Rectangle {
            corner, edges, normal, ..
        } = self.rectangle;
        let center = corner + (edges[0] + edges[1]) * 0.5;
        let to = center - self.from;
        let distance2 = to.length_squared();
        let estimate = self.rectangle.area() * normal.dot(to).abs() / (distance2 * distance2.sqrt());
        if estimate.is_finite() { estimate } else { 0.0 }
    }

    /// A point of it.
    #[inline]
    pub fn sample(&self, u: f64, v: f64) -> DVec3 {
        let lengths = self.rectangle.lengths;
        let [u, v] = self.spherical.map_or([u, v], |s| {
            let [x, y] = s.sample(u, v);
            [(x - s.x[0]) / lengths[0], (y - s.y[0]) / lengths[1]]
        });
        self.rectangle.point(u, v)
    }

    /// The density of [`SeenRectangle::sample`] at its point `p`, in sr^-1.
    #[inline]
    pub fn pdf(&self, p: DVec3) -> f32 {
        match self.spherical {
            Some(s) => (1.0 / s.solid_angle) as f32,
            None => self.rectangle.pdf_by_area(self.from, p),
        }
    }
}

/// The squared distances of 0 from the nearest and from the farthest number between `a` and `b`, of which `a` is the smaller.
#[inline(always)]
fn nearest2([a, b]: [f64; 2]) -> f64 {
    let nearest = a.max(0.0) + b.min(0.0);
    nearest * nearest
}

#[inline(always)]
fn farthest2([a, b]: [f64; 2]) -> f64 {
    (a * a).max(b * b)
}

/// The ends of a rectangle along its edges as seen from a point, and its height along the normal.
#[inline(always)]
fn sides(from: DVec3, rectangle: &Rectangle) -> ([f64; 2], [f64; 2], f64) {
    let Rectangle {
        corner,
        edges,
        lengths,
        normal,
    } = *rectangle;
    let d = corner - from;
    let (x, y) = (d.dot(edges[0]) / lengths[0], d.dot(edges[1]) / lengths[1]);
    ([x, x + lengths[0]], [y, y + lengths[1]], d.dot(normal))
}

impl Spherical {
    /// `None` where the rectangle is sampled by area: where that is as good, where its solid angle is too small for its
    /// angles to tell, and where it is seen edge-on.
    #[inline]
    fn new(from: DVec3, rectangle: &Rectangle) -> Option<Self> {
        if rectangle.is_sampled_by_area(from) {
            return None;
        }
        Self::whole(from, rectangle)
    }

    /// The same, and also where sampling by area is as good.
    fn whole(from: DVec3, rectangle: &Rectangle) -> Option<Self> {
        let (x, y, z) = sides(from, rectangle);
        Self::of_sides(x, y, z)
    }

    /// The rectangle of the sides `x` and `y` at the height `z`; `None` where its solid angle is too small.
    ///
    /// With the observer's foot in a corner, a rectangle of the sides x and y has the solid angle atan(x y / (z r)), r the
    /// distance of the opposite corner. Any other is made of four of these, whose angles add up as complex numbers multiply.
    fn of_sides(x: [f64; 2], y: [f64; 2], z: f64) -> Option<Self> {
        if z == 0.0 {
            return None;
        }
        let z2 = z * z;
        let angle = |x: f64, y: f64| DVec2::new(z.abs() * (x * x + y * y + z2).sqrt(), x * y);
        let near = quotient(angle(x[0], y[0]), angle(x[0], y[1]));
        let far = quotient(angle(x[1], y[1]), angle(x[1], y[0]));
        let all = product(near, far);
        let whole = libm::atan2(all.y, all.x);
        let solid_angle = if whole < 0.0 { whole + TAU } else { whole };
        (solid_angle >= SMALLEST_SOLID_ANGLE).then(|| Self {
            x,
            y,
            z,
            ridges: y.map(|y| DVec2::new(y, (y * y + z2).sqrt())),
            turn: near / near.length(),
            solid_angle,
        })
    }

    /// The x and y of a point of the rectangle.
    #[inline]
    fn sample(&self, u: f64, v: f64) -> [f64; 2] {
        let (sin, cos) = trig::sin_cos((u * self.solid_angle) as f32);
        let phi = quotient(DVec2::new(cos.into(), sin.into()), self.turn);
        let [low, high] = self.ridges.map(|ridge| ridge.x / ridge.y);
        // As the source has it, with both signs turned over: phi is less by half a turn here.
        let f: f64 = (high - phi.x * low) / phi.y;
        let c: f64 = (1.0 / (f * f + low * low).sqrt()).copysign(f).clamp(-1.0, 1.0);
        let x = c * self.z.abs() / (1.0 - c * c).max(0.0).sqrt();
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
        [x, y]
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn seen(from: DVec3, corner: DVec3, edges: [DVec3; 2]) -> SeenRectangle {
        Rectangle {
            corner,
            edges,
            lengths: edges.map(DVec3::length),
            normal: edges[0].cross(edges[1]).normalize(),
        }
        .seen_from(from)
    }

    #[test]
    fn a_face_of_a_cube_fills_a_sixth_of_all_directions_from_its_middle() {
        let seen = seen(
            DVec3::ZERO,
            DVec3::new(-1.0, -1.0, 1.0),
            [DVec3::X * 2.0, DVec3::Y * 2.0],
        );
        assert!((seen.solid_angle() - 4.0 * PI / 6.0).abs() < 1e-12);
    }

    #[test]
    fn solid_angle_of_a_far_rectangle_is_its_area_over_distance_squared() {
        for distance in [90.0, 110.0, 1e4] {
            let seen = seen(DVec3::new(0.5, 0.5, distance), DVec3::ZERO, [DVec3::X, DVec3::Y]);
            let expected = 1.0 / (distance * distance);
            assert!((seen.solid_angle() / expected - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn points_are_uniform_by_solid_angle() {
        // A quarter of the numbers must fall on the quarter of the rectangle that sees as much as
        // the other three.
        let from = DVec3::new(0.3, -0.4, 0.5);
        let seen = seen(from, DVec3::ZERO, [DVec3::X, DVec3::Y * 3.0]);
        let part = self::seen(from, DVec3::ZERO, [DVec3::X * 0.6, DVec3::Y * 0.7]);
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
