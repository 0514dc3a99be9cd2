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
    LocalSurface, Shape, ShapeHit, ShapeKind, ShapeSample,
    axis::whole_turn,
    ball::Ball,
    block::{Attempt, BlockKind, intersected_in_blocks, vector},
    numeric::{Or, point_of, rounded, rounded_hit},
    sample_block::SampleBlock,
    sampled::SampledKind,
};
use crate::{
    math::{Aabb, DVec3, Ray, Vec2, Vec3, trig},
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

impl Sphere {
    #[inline(always)]
    fn ball(&self) -> Ball {
        Ball {
            center: self.center,
            radius: self.radius,
        }
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

impl From<Sphere> for Shape {
    fn from(sphere: Sphere) -> Self {
        Self::Sphere(sphere)
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
        let (p, p_error) = rounded(self.ball().at(n), f64::from(self.center.abs().max_element()) + r);
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
        (1.0 / self.ball().per_area()) as f32
    }

    fn sample(&self, from: Vec3, u: Vec2) -> Option<ShapeSample> {
        self.ball().sample_one(from, u)
    }

    #[inline]
    fn put_in_block(&self, lane: usize, block: &mut SampleBlock) -> bool {
        block.set_ball(lane, &self.ball());
        true
    }

    fn pdf(&self, from: Vec3, wi: Vec3, hit: &ShapeHit) -> f32 {
        self.ball()
            .pdf(from, || self.normal_at(point_of(&Ray::new(from, wi), hit)))
    }
}
