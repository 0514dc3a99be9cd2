//! A right circular cylinder, open or with caps.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `base` | centre of the base, `[x, y, z]` | m | `[0, 0, 0]` |
//! | `axis` | direction from the base to the top | | `[0, 1, 0]` |
//! | `radius` | number above 0 | m | required |
//! | `height` | number above 0 | m | required |
//! | `caps` | whether the base and the top are closed | | `true` |
//! | `outside_only` | whether only rays that enter the wall meet it; needs `caps = false` | | `false` |
//!
//! ```toml
//! shape.cylinder = { base = [0, 0, 0], axis = [0, 1, 0], radius = 0.5, height = 2 }
//! ```
//!
//! The cylinder reaches from `base` to `base + axis * height`. Normals point outwards, also where a ray meets the wall from
//! inside. On the wall `u` runs around the axis in `[0, 1)`, for an axis of +y from +x towards +z, and `v` from the base (0)
//! to the top (1); on the caps `u` is the same and `v` runs from the centre (0) to the rim (1).
//!
//! With `outside_only` the wall is invisible from inside.
//!
//! # Implementation
//!
//! With caps, a ray meets the cylinder where it enters or leaves the overlap of two intervals: the one inside the infinite
//! cylinder and the one between the two end planes. So there is no seam at the rims. Points are sampled uniformly by area;
//! those on the far side of a closed cylinder are rejected.

use std::f64::consts::TAU;

use serde::Deserialize;

use super::{
    LocalSurface, Shape, ShapeHit, ShapeKind, ShapeSample,
    axis::Axis,
    block::{Attempt, BlockKind, intersected_in_blocks, vector},
    disk::disk_bounds,
    numeric::{Or, choose, dot_direction, point_of, rounded, solid_angle_pdf},
    round::{BASE, Parts, Round, RoundDesc, TOP, WALL},
};
use crate::{
    math::{Aabb, DVec3, Ray, Vec2, Vec3},
    value::Problem,
};

/// The description of a cylinder in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub struct CylinderDesc(RoundDesc);

impl CylinderDesc {
    /// A point of the shape.
    pub fn anchor(&self) -> Option<DVec3> {
        self.0.anchor()
    }

    pub fn compile(&self, origin: DVec3) -> Result<Cylinder, Problem> {
        self.0.compile(origin).map(Cylinder)
    }
}

/// A cylinder, its wall alone or with caps.
#[derive(Clone, Copy, Debug)]
pub struct Cylinder(Round);

impl Cylinder {
    /// A wall without caps around the unit `axis` from `base` on, which only rays that enter it meet.
    pub fn wall(base: Vec3, axis: Vec3, height: f32, radius: f32) -> Self {
        Self(Round {
            base,
            radius,
            height,
            parts: Parts::OpenFromOutside,
            axis: Axis::new(axis),
        })
    }

    /// The areas of wall, base and top, in m^2.
    fn areas(&self) -> [f64; 3] {
        let (r, h) = (f64::from(self.0.radius), f64::from(self.0.height));
        let cap = self.0.cap_area();
        [TAU * r * h, cap, cap]
    }

    /// Per m^2.
    fn per_area(&self) -> f64 {
        1.0 / self.areas().iter().sum::<f64>()
    }

    fn contains(&self, p: Vec3) -> bool {
        let q = p.as_dvec3() - self.0.base.as_dvec3();
        let (z, r) = (q.dot(self.0.axis.0), f64::from(self.0.radius));
        z >= 0.0 && z <= self.0.height.into() && self.0.axis.across(q).length_squared() <= r * r
    }

    fn wall_surface(&self, q: DVec3) -> LocalSurface {
        let (r, h) = (f64::from(self.0.radius), f64::from(self.0.height));
        let z = q.dot(self.0.axis.0).clamp(0.0, h);
        let (e, _) = self.0.axis.outwards(q);
        let base = self.0.base.as_dvec3();
        let (p, p_error) = rounded(base + self.0.axis.0 * z + e * r, base.abs().max_element() + r + h);
        LocalSurface {
            p,
            p_error,
            ng: e.as_vec3(),
            uv: Vec2::new(self.0.axis.turn(e), (z / h) as f32),
            dpdu: (self.0.axis.tangent(e) * (TAU * r)).as_vec3(),
            dpdv: (self.0.axis.0 * h).as_vec3(),
        }
    }
}

impl BlockKind<9> for Cylinder {
    #[inline(always)]
    fn numbers(&self) -> [f64; 9] {
        let (b, w) = (self.0.base.as_dvec3(), self.0.axis.0);
        let (r, h) = (self.0.radius.into(), self.0.height.into());
        [b.x, b.y, b.z, w.x, w.y, w.z, r, h, self.0.parts.number()]
    }

    #[inline(always)]
    fn attempt(numbers: &[f64; 9], ray: &Ray) -> Attempt {
        let (base, axis) = (vector(numbers, 0), Axis(vector(numbers, 3)));
        let [.., r, height, parts] = *numbers;
        let q = ray.o.as_dvec3() - base;
        // The stretch of the line inside the endless cylinder: all of it or nothing for a line along the axis.
        let (around, across) = (axis.across(q), axis.across(ray.d.as_dvec3()));
        let a = across.length_squared();
        let is_along = a == 0.0;
        let closest_t = -around.dot(across) / a;
        let h2 = r * r - (around + across * closest_t).length_squared();
        let half = (h2 / a).sqrt();
        let inside = (closest_t - half, closest_t + half);
        let (enter, leave) = (f64::NEG_INFINITY, f64::INFINITY).or(is_along, inside);
        let meets_wall = (is_along & (around.length_squared() <= r * r)) | (!is_along & (h2 >= 0.0));
        // The stretch between the two end planes.
        let (along, at) = (dot_direction(ray.d, axis.0), q.dot(axis.0));
        let is_level = along == 0.0;
        let base = (-at / along, BASE).or(!is_level, (f64::NEG_INFINITY, BASE));
        let top = ((height - at) / along, TOP).or(!is_level, (f64::INFINITY, TOP));
        let rises = is_level | (along > 0.0);
        let ends = [base.or(rises, top), top.or(rises, base)];
        let meets_ends = !is_level | ((at >= 0.0) & (at <= height));
        let (hit, meets) = Parts::hit(parts, ray, [enter, leave], ends);
        Attempt::of(hit, meets & meets_wall & meets_ends)
    }
}

impl From<Cylinder> for Shape {
    fn from(cylinder: Cylinder) -> Self {
        Self::Cylinder(cylinder)
    }
}

impl ShapeKind for Cylinder {
    fn curvature(&self) -> f32 {
        1.0 / self.0.radius
    }

    fn bounds(&self) -> Aabb {
        self.0
            .base_bounds()
            .union(disk_bounds(self.0.axis, self.0.top(), self.0.radius))
    }

    intersected_in_blocks!();

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> LocalSurface {
        let q = point_of(ray, hit) - self.0.base.as_dvec3();
        match hit.u {
            WALL => self.wall_surface(q),
            TOP => self.0.cap_surface(self.0.top(), q),
            _ => self.0.base_surface(q),
        }
    }

    fn area(&self) -> f32 {
        (1.0 / self.per_area()) as f32
    }

    fn sample(&self, from: Vec3, u: Vec2) -> Option<ShapeSample> {
        let (part, ux) = choose(&self.areas(), u.x);
        let turn = f64::from(u.y);
        let base = self.0.base.as_dvec3();
        let point = match part {
            0 => {
                let e = self.0.axis.ring(turn);
                let z = ux * f64::from(self.0.height);
                (base + self.0.axis.0 * z + e * f64::from(self.0.radius), e)
            }
            1 => (self.0.cap_point(base, ux, turn), -self.0.axis.0),
            _ => (self.0.cap_point(self.0.top(), ux, turn), self.0.axis.0),
        };
        self.0.sample(self.per_area(), from, point, || self.contains(from))
    }

    fn pdf(&self, from: Vec3, wi: Vec3, hit: &ShapeHit) -> f32 {
        let s = self.surface(&Ray::new(from, wi), hit);
        solid_angle_pdf(self.per_area(), from.as_dvec3(), s.p.as_dvec3(), s.ng.as_dvec3())
    }
}
