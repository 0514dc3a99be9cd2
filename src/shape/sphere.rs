//! A sphere.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `center` | `[x, y, z]` | m | `[0, 0, 0]` |
//! | `radius` | number above 0 | m | required |
//!
//! ```toml
//! shape.sphere = { center = [0, 1, 0], radius = 1 }
//! ```
//!
//! Normals point outwards. The parameter `u` runs around the y axis from +x towards +z in `[0, 1)`, and `v` from the south
//! pole (0) to the north pole (1) in equal steps of latitude.
//!
//! # Implementation
//!
//! From outside, directions are sampled uniformly within the cone that the sphere subtends; from inside, points are sampled
//! uniformly by area. Source of the cone: Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th ed., section 6.2.4;
//! here it is computed from 1 - cos, which stays precise for the narrowest cones. At the poles, where `u` has no direction
//! of its own, `dpdu` is that of u = 0: very short, but not 0.

use std::f64::consts::{PI, TAU};

use serde::Deserialize;

use super::{
    LocalSurface, ShapeHit, ShapeKind, ShapeSample,
    axis::{Axis, whole_turn},
    block::{Attempt, BlockKind, intersected_in_blocks, vector},
    numeric::{Or, area_sample, point_of, rounded, rounded_hit, solid_angle_pdf},
};
use crate::{
    math::{Aabb, DVec3, Ray, Vec2, Vec3, float::gamma, trig},
    value::{Point, Positive, Problem},
};

/// The description of a sphere in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereDesc {
    #[serde(default)]
    pub center: Point,
    pub radius: Positive,
}

impl SphereDesc {
    /// A point of the shape.
    pub fn anchor(&self) -> Option<DVec3> {
        Some(self.center.0)
    }

    pub fn compile(&self, origin: DVec3) -> Result<Sphere, Problem> {
        Ok(Sphere {
            center: self.center.relative_to(origin),
            radius: self.radius.0,
        })
    }
}

/// A sphere, seen from outside and from inside.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    pub center: Vec3,
    pub radius: f32,
}

/// The cone of directions in which a sphere is seen from outside.
struct SubtendedCone {
    /// From the centre to the observer.
    axis: Axis,
    distance: f64,
    sin2_max: f64,
    /// 1 - cos of the half angle.
    one_minus_cos: f64,
}

impl SubtendedCone {
    /// Per sr.
    fn pdf(&self) -> f32 {
        (1.0 / (TAU * self.one_minus_cos)) as f32
    }
}

impl Sphere {
    /// `None` from inside, and from the surface itself: rounding puts half of its points outside,
    /// and the cone of those would hold the near side only.
    fn cone(&self, from: Vec3) -> Option<SubtendedCone> {
        let out = from.as_dvec3() - self.center.as_dvec3();
        let (distance, r) = (out.length(), f64::from(self.radius));
        let rounding = f64::from(gamma(32)) * (f64::from(self.center.abs().max_element()) + r);
        if distance <= r + rounding {
            return None;
        }
        let sin2_max = (r / distance) * (r / distance);
        let cos = ((distance - r) * (distance + r)).sqrt() / distance;
        Some(SubtendedCone {
            axis: Axis(out / distance),
            distance,
            sin2_max,
            one_minus_cos: sin2_max / (1.0 + cos),
        })
    }

    fn at(&self, n: DVec3) -> DVec3 {
        self.center.as_dvec3() + n * f64::from(self.radius)
    }

    /// Per m^2.
    fn per_area(&self) -> f64 {
        let r = f64::from(self.radius);
        1.0 / (4.0 * PI * r * r)
    }

    fn normal_at(&self, p: DVec3) -> DVec3 {
        (p - self.center.as_dvec3()).normalize_or(DVec3::Y)
    }
}

impl BlockKind<4> for Sphere {
    #[inline(always)]
    fn numbers(&self) -> [f64; 4] {
        let c = self.center.as_dvec3();
        [c.x, c.y, c.z, self.radius.into()]
    }

    /// Works in double precision, from the point of the ray nearest to the centre: the discriminant of a
    /// small sphere far away cancels otherwise.
    #[inline(always)]
    fn attempt(numbers: &[f64; 4], ray: &Ray) -> Attempt {
        let (center, r) = (vector(numbers, 0), numbers[3]);
        let d = ray.d.as_dvec3();
        let oc = ray.o.as_dvec3() - center;
        let inv_a = d.length_squared().recip();
        let closest_t = -oc.dot(d) * inv_a;
        let closest = oc + d * closest_t;
        let h2 = r * r - closest.length_squared();
        let half = (h2 * inv_a).sqrt();
        let (near, is_near_on_ray) = rounded_hit(ray, closest_t - half, 0.0);
        let (far, is_far_on_ray) = rounded_hit(ray, closest_t + half, 0.0);
        let meets = (h2 >= 0.0) & (is_near_on_ray | is_far_on_ray);
        Attempt::of(near.or(is_near_on_ray, far), meets)
    }
}

impl ShapeKind for Sphere {
    fn curvature(&self) -> f32 {
        1.0 / self.radius
    }

    fn bounds(&self) -> Aabb {
        Aabb {
            min: self.center - self.radius,
            max: self.center + self.radius,
        }
        .padded(1.0)
    }

    intersected_in_blocks!();

    #[inline]
    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> LocalSurface {
        let r = f64::from(self.radius);
        let n = self.normal_at(point_of(ray, hit));
        let (p, p_error) = rounded(self.at(n), f64::from(self.center.abs().max_element()) + r);
        let ring = (n.x * n.x + n.z * n.z).sqrt();
        let (cos_phi, sin_phi) = if ring > 0.0 {
            (n.x / ring, n.z / ring)
        } else {
            (1.0, 0.0)
        };
        let along = ring.max(f64::from(f32::EPSILON)) * r * TAU;
        LocalSurface {
            p,
            p_error,
            ng: n.as_vec3(),
            uv: Vec2::new(
                whole_turn(trig::atan2(n.z as f32, n.x as f32).into()),
                trig::atan2(n.y as f32, ring as f32) / std::f32::consts::PI + 0.5,
            ),
            dpdu: (DVec3::new(-sin_phi, 0.0, cos_phi) * along).as_vec3(),
            dpdv: (DVec3::new(-n.y * cos_phi, ring, -n.y * sin_phi) * (PI * r)).as_vec3(),
        }
    }

    fn area(&self) -> f32 {
        (1.0 / self.per_area()) as f32
    }

    fn sample(&self, from: Vec3, u: Vec2) -> Option<ShapeSample> {
        let u = u.as_dvec2();
        let Some(cone) = self.cone(from) else {
            let y = 1.0 - 2.0 * u.x;
            let n = Axis(DVec3::Y).ring(u.y) * (1.0 - y * y).max(0.0).sqrt() + DVec3::Y * y;
            return area_sample(self.per_area(), from, self.at(n), n);
        };
        // The direction's angle with the cone's axis, then the angle at the centre, by the law of
        // sines.
        let h = u.x * cone.one_minus_cos;
        let sin2 = h * (2.0 - h);
        let r = f64::from(self.radius);
        let near = cone.distance * (1.0 - h) - (r * r * (1.0 - sin2 / cone.sin2_max).max(0.0)).sqrt();
        let sin_alpha = (near * sin2.sqrt() / r).min(1.0);
        let cos_alpha = (cone.distance - near * (1.0 - h)) / r;
        let n = (cone.axis.0 * cos_alpha + cone.axis.ring(u.y) * sin_alpha).normalize_or(cone.axis.0);
        Some(ShapeSample {
            p: self.at(n).as_vec3(),
            ng: n.as_vec3(),
            pdf: cone.pdf(),
        })
    }

    fn pdf(&self, from: Vec3, wi: Vec3, hit: &ShapeHit) -> f32 {
        self.cone(from).map_or_else(
            || {
                let n = self.normal_at(point_of(&Ray::new(from, wi), hit));
                solid_angle_pdf(self.per_area(), from.as_dvec3(), self.at(n), n)
            },
            |cone| cone.pdf(),
        )
    }
}
