//! Points of a sphere as seen from a point.

use std::f64::consts::{PI, TAU};

use super::{
    axis::Axis,
    block::vector,
    numeric::{Or, solid_angle_pdf},
    sampled::{SampledKind, SampledPoint},
};
use crate::math::{DVec3, Vec2, Vec3, float::gamma};

/// A sphere that is sampled: from outside by directions, from inside by area.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub center: Vec3,
    pub radius: f32,
}

/// The cone of directions in which a sphere is seen from outside.
struct SubtendedCone {
    /// From the centre to the observer.
    axis: DVec3,
    distance: f64,
    sin2_max: f64,
    /// 1 - cos of the half angle.
    one_minus_cos: f64,
    /// Not from inside, and not from the surface itself: rounding puts half of its points outside, and the cone of those would
    /// hold the near side only. If false, the other fields are unspecified.
    is_seen: bool,
}

impl SubtendedCone {
    /// Per sr.
    #[inline(always)]
    fn pdf(&self) -> f32 {
        (1.0 / (TAU * self.one_minus_cos)) as f32
    }
}

impl Ball {
    #[inline(always)]
    fn cone(&self, from: Vec3) -> SubtendedCone {
        let out = from.as_dvec3() - self.center.as_dvec3();
        let (distance, r) = (out.length(), f64::from(self.radius));
        let rounding = f64::from(gamma(32)) * (f64::from(self.center.abs().max_element()) + r);
        let sin2_max = (r / distance) * (r / distance);
        let cos = ((distance - r) * (distance + r)).sqrt() / distance;
        SubtendedCone {
            axis: out / distance,
            distance,
            sin2_max,
            one_minus_cos: sin2_max / (1.0 + cos),
            is_seen: distance > r + rounding,
        }
    }

    #[inline(always)]
    pub fn at(&self, n: DVec3) -> DVec3 {
        self.center.as_dvec3() + n * f64::from(self.radius)
    }

    /// Per m^2.
    #[inline(always)]
    pub fn per_area(&self) -> f64 {
        let r = f64::from(self.radius);
        1.0 / (4.0 * PI * r * r)
    }

    /// The density of its samples, in sr^-1 as seen from `from`; `normal` returns the normal at the point.
    pub fn pdf(&self, from: Vec3, normal: impl FnOnce() -> DVec3) -> f32 {
        let cone = self.cone(from);
        if cone.is_seen {
            return cone.pdf();
        }
        let n = normal();
        solid_angle_pdf(self.per_area(), from.as_dvec3(), self.at(n), n)
    }
}

impl SampledKind<4> for Ball {
    #[inline(always)]
    fn sample_numbers(&self) -> [f64; 4] {
        [
            self.center.x.into(),
            self.center.y.into(),
            self.center.z.into(),
            self.radius.into(),
        ]
    }

    #[inline(always)]
    fn sample_by(numbers: &[f64; 4], from: Vec3, u: Vec2) -> SampledPoint {
        let ball = Self {
            center: vector(numbers, 0).as_vec3(),
            radius: numbers[3] as f32,
        };
        let (cone, r, u) = (ball.cone(from), numbers[3], u.as_dvec2());
        // The direction's angle with the cone's axis, then the angle at the centre, by the law of
        // sines.
        let h = u.x * cone.one_minus_cos;
        let sin2 = h * (2.0 - h);
        let near = cone.distance * (1.0 - h) - (r * r * (1.0 - sin2 / cone.sin2_max).max(0.0)).sqrt();
        let outside = (
            (cone.distance - near * (1.0 - h)) / r,
            (near * sin2.sqrt() / r).min(1.0),
        );
        let y = 1.0 - 2.0 * u.x;
        let (cos, sin) = outside.or(cone.is_seen, (y, (1.0 - y * y).max(0.0).sqrt()));
        let axis = Axis(DVec3::new(
            cone.axis.x.or(cone.is_seen, 0.0),
            cone.axis.y.or(cone.is_seen, 1.0),
            cone.axis.z.or(cone.is_seen, 0.0),
        ));
        let n = (axis.0 * cos + axis.ring(u.y) * sin).normalize();
        let p = ball.at(n);
        let by_area = solid_angle_pdf(ball.per_area(), from.as_dvec3(), p, n);
        SampledPoint::new(p.as_vec3(), n.as_vec3(), cone.pdf().or(cone.is_seen, by_area))
    }
}
