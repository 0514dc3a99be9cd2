//! A flat disk.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `center` | `[x, y, z]` | m | `[0, 0, 0]` |
//! | `normal` | direction | | `[0, 1, 0]` |
//! | `radius` | number above 0 | m | required |
//!
//! ```toml
//! shape.disk = { center = [0, 3, 0], normal = [0, -1, 0], radius = 0.5 }
//! ```
//!
//! Both sides have the given normal. The parameter `u` runs around the normal in `[0, 1)`, for a normal of +y from +x
//! towards +z, and `v` from the centre (0) to the rim (1).
//!
//! # Implementation
//!
//! Points are sampled uniformly by area.

use std::f64::consts::{PI, TAU};

use serde::Deserialize;

use super::{
    LocalSurface, Shape, ShapeHit, ShapeKind, ShapeSample,
    axis::Axis,
    block::{Attempt, BlockKind, intersected_in_blocks, vector},
    numeric::{area_sample, dot_direction, point_of, rounded, rounded_hit, solid_angle_pdf},
};
use crate::{
    math::{Aabb, DVec3, Ray, Vec2, Vec3},
    value::{Direction, Point, Positive, Problem},
};

/// The description of a disk in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DiskDesc {
    #[serde(default)]
    pub center: Point,
    #[serde(default = "Direction::up")]
    pub normal: Direction,
    pub radius: Positive,
}

impl DiskDesc {
    /// A point of the shape.
    pub fn anchor(&self) -> Option<DVec3> {
        Some(self.center.0)
    }

    pub fn compile(&self, origin: DVec3) -> Result<Disk, Problem> {
        Ok(Disk {
            center: self.center.relative_to(origin),
            radius: self.radius.0,
            axis: Axis::new(self.normal.0),
        })
    }
}

/// A disk, seen from both sides.
#[derive(Clone, Copy, Debug)]
pub struct Disk {
    center: Vec3,
    radius: f32,
    axis: Axis,
}

impl Disk {
    /// Unit.
    pub fn normal(&self) -> Vec3 {
        self.axis.0.as_vec3()
    }

    /// Per m^2.
    fn per_area(&self) -> f64 {
        let r = f64::from(self.radius);
        1.0 / (PI * r * r)
    }

    /// The direction from the centre towards the point of the disk nearest to `p`, and the
    /// distance.
    fn polar(&self, p: DVec3) -> (DVec3, f64) {
        let (e, rho) = self.axis.outwards(p - self.center.as_dvec3());
        (e, rho.min(f64::from(self.radius)))
    }
}

impl BlockKind<7> for Disk {
    #[inline(always)]
    fn numbers(&self) -> [f64; 7] {
        let (c, w) = (self.center.as_dvec3(), self.axis.0);
        [c.x, c.y, c.z, w.x, w.y, w.z, self.radius.into()]
    }

    #[inline(always)]
    fn attempt(numbers: &[f64; 7], ray: &Ray) -> Attempt {
        let (center, axis, r) = (vector(numbers, 0), Axis(vector(numbers, 3)), numbers[6]);
        let q = ray.o.as_dvec3() - center;
        let t = -q.dot(axis.0) / dot_direction(ray.d, axis.0);
        let across = axis.across(q + ray.d.as_dvec3() * t);
        let (hit, is_on_ray) = rounded_hit(ray, t, 0.0);
        Attempt::of(hit, is_on_ray & (across.length_squared() <= r * r))
    }
}

impl From<Disk> for Shape {
    fn from(disk: Disk) -> Self {
        Self::Disk(disk)
    }
}

impl ShapeKind for Disk {
    fn bounds(&self) -> Aabb {
        disk_bounds(self.axis, self.center.as_dvec3(), self.radius)
    }

    intersected_in_blocks!();

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> LocalSurface {
        let (e, rho) = self.polar(point_of(ray, hit));
        polar_surface(self.axis, self.center.as_dvec3(), self.radius, e, rho)
    }

    fn flat_normal(&self) -> Option<Vec3> {
        Some(self.normal())
    }

    fn area(&self) -> f32 {
        (1.0 / self.per_area()) as f32
    }

    fn sample(&self, from: Vec3, u: Vec2) -> Option<ShapeSample> {
        let p = self.center.as_dvec3() + disk_point(self.axis, self.radius, u.x.into(), u.y.into());
        area_sample(self.per_area(), from, p, self.axis.0)
    }

    fn pdf(&self, from: Vec3, wi: Vec3, hit: &ShapeHit) -> f32 {
        let (e, rho) = self.polar(point_of(&Ray::new(from, wi), hit));
        let p = self.center.as_dvec3() + e * rho;
        solid_angle_pdf(self.per_area(), from.as_dvec3(), p, self.axis.0)
    }
}

/// The box around a disk.
pub(super) fn disk_bounds(axis: Axis, center: DVec3, radius: f32) -> Aabb {
    let half = axis.circle_extent(radius.into());
    Aabb {
        min: (center - half).as_vec3(),
        max: (center + half).as_vec3(),
    }
    .padded(1.0)
}

/// A point of the disk around the origin, uniform by area.
pub(super) fn disk_point(axis: Axis, radius: f32, u: f64, turn: f64) -> DVec3 {
    axis.ring(turn) * (u.sqrt() * f64::from(radius))
}

/// The surface of a disk at `rho` from its centre in the direction `e`, in polar coordinates, its
/// normal the axis.
pub(super) fn polar_surface(axis: Axis, center: DVec3, radius: f32, e: DVec3, rho: f64) -> LocalSurface {
    let r = f64::from(radius);
    let (p, p_error) = rounded(center + e * rho, center.abs().max_element() + r);
    let along = rho.max(r * f64::from(f32::EPSILON)) * TAU;
    LocalSurface {
        p,
        p_error,
        ng: axis.0.as_vec3(),
        uv: Vec2::new(axis.turn(e), (rho / r) as f32),
        dpdu: (axis.tangent(e) * along).as_vec3(),
        dpdv: (e * r).as_vec3(),
    }
}
