//! An infinite plane.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `point` | a point of the plane, `[x, y, z]` | m | `[0, 0, 0]` |
//! | `normal` | direction | | `[0, 1, 0]` |
//!
//! ```toml
//! shape.plane = { point = [0, -1, 0], normal = [0, 1, 0] }
//! ```
//!
//! Both sides have the given normal. The parameters `u` and `v` count metres from `point`: for a normal of +y, `u` along +x
//! and `v` along -z. A plane that emits light is found by chance only, because an infinite surface cannot be sampled.
//!
//! # Implementation
//!
//! The tangents are those of [`Frame::from_normal`]. A plane has neither bounds nor an area.

use glam::DVec2;
use serde::Deserialize;

use super::{
    LocalSurface, ShapeHit, ShapeKind, ShapeSample,
    axis::Axis,
    numeric::{dot_direction, hit_at, point_of, rounded},
};
use crate::{
    math::{Aabb, DVec3, Frame, Ray, Vec2, Vec3},
    value::{Direction, Point, Problem},
};

/// The description of a plane in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneDesc {
    #[serde(default)]
    pub point: Point,
    #[serde(default = "Direction::up")]
    pub normal: Direction,
}

impl PlaneDesc {
    /// An unbounded shape is nowhere in particular.
    pub fn anchor(&self) -> Option<DVec3> {
        None
    }

    pub fn compile(&self, origin: DVec3) -> Result<Plane, Problem> {
        let axis = Axis::new(self.normal.0);
        let point = self.point.0 - origin;
        // Far from its point a plane is precise around the point that is nearest to the origin.
        let across = if origin == DVec3::ZERO {
            DVec3::ZERO
        } else {
            axis.across(point)
        };
        let frame = Frame::from_normal(axis.0.as_vec3());
        Ok(Plane {
            point: (point - across).as_vec3(),
            axis,
            uv: -DVec2::new(across.dot(frame.s.as_dvec3()), across.dot(frame.t.as_dvec3())),
        })
    }
}

/// A plane, seen from both sides.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    point: Vec3,
    axis: Axis,
    /// The parameters at `point`.
    uv: DVec2,
}

impl ShapeKind for Plane {
    fn bounds(&self) -> Aabb {
        Aabb::UNBOUNDED
    }

    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let q = self.point.as_dvec3() - ray.o.as_dvec3();
        hit_at(ray, q.dot(self.axis.0) / dot_direction(ray.d, self.axis.0), 0.0)
    }

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> LocalSurface {
        let point = self.point.as_dvec3();
        let q = self.axis.across(point_of(ray, hit) - point);
        let (p, p_error) = rounded(point + q, point.abs().max_element() + q.abs().max_element());
        let ng = self.axis.0.as_vec3();
        let frame = Frame::from_normal(ng);
        let uv = self.uv + DVec2::new(q.dot(frame.s.as_dvec3()), q.dot(frame.t.as_dvec3()));
        LocalSurface {
            p,
            p_error,
            ng,
            uv: uv.as_vec2(),
            dpdu: frame.s,
            dpdv: frame.t,
        }
    }

    fn flat_normal(&self) -> Option<Vec3> {
        Some(self.axis.0.as_vec3())
    }

    fn area(&self) -> f32 {
        f32::INFINITY
    }

    fn sample(&self, _from: Vec3, _u: Vec2) -> Option<ShapeSample> {
        None
    }

    fn pdf(&self, _from: Vec3, _wi: Vec3, _hit: &ShapeHit) -> f32 {
        0.0
    }
}
