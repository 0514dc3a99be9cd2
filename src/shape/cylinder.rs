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

use std::f64::consts::{PI, TAU};

use serde::Deserialize;

use super::{
    LocalSurface, ShapeHit, ShapeKind, ShapeSample,
    axis::Axis,
    block::{Attempt, BlockKind, Numbers, RayBlock, intersect_one, numbers, vector},
    disk::{disk_bounds, disk_point, polar_surface},
    numeric::{Or, area_sample, choose, dot_direction, point_of, rounded, rounded_hit, solid_angle_pdf},
};
use crate::{
    math::{Aabb, DVec3, Dispatch, Ray, Vec2, Vec3},
    value::{Direction, Point, Positive, Problem, Spanned},
};

/// The description of a cylinder in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CylinderDesc {
    #[serde(default = "origin")]
    pub base: Point,
    #[serde(default = "up")]
    pub axis: Direction,
    pub radius: Positive,
    pub height: Positive,
    #[serde(default = "yes")]
    pub caps: bool,
    #[serde(default)]
    pub outside_only: Option<Spanned<bool>>,
}

fn origin() -> Point {
    Point(DVec3::ZERO)
}

fn up() -> Direction {
    Direction(Vec3::Y)
}

fn yes() -> bool {
    true
}

/// Which parts of a cylinder or a cone there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parts {
    /// Wall and caps: a solid.
    Closed,
    /// The wall alone.
    Open,
    /// The wall alone, for rays that enter.
    OpenFromOutside,
}

impl Parts {
    /// From what a file says of `caps` and `outside_only`.
    pub fn compile(caps: bool, outside_only: Option<&Spanned<bool>>) -> Result<Self, Problem> {
        match outside_only.filter(|o| *o.get_ref()) {
            Some(outside) if caps => Err(Problem::at(
                outside.span(),
                "`outside_only` is for open walls, and this one has caps",
            )
            .with_help("add `caps = false`")),
            Some(_) => Ok(Self::OpenFromOutside),
            None if caps => Ok(Self::Closed),
            None => Ok(Self::Open),
        }
    }

    /// Whether a point of the surface is hidden from an observer that it looks away from, who may
    /// be inside.
    pub fn hide(self, inside: impl Fn() -> bool) -> bool {
        match self {
            Self::Closed => !inside(),
            Self::Open => false,
            Self::OpenFromOutside => true,
        }
    }

    /// The number that stands for it in a block.
    #[inline(always)]
    pub fn number(self) -> f64 {
        f64::from(self as u8)
    }

    /// The hit of a ray with the parts of this number, and whether there is one; of where the ray enters and leaves the wall,
    /// and where it enters and leaves what lies between the ends, each with its part's number.
    #[inline(always)]
    pub fn hit(parts: f64, ray: &Ray, [enter, leave]: [f64; 2], ends: [(f64, f32); 2]) -> (ShapeHit, bool) {
        let is_closed = parts == Self::Closed.number();
        let first = (enter, WALL).or(enter >= ends[0].0, ends[0]);
        let last = (leave, WALL).or(leave <= ends[1].0, ends[1]);
        let overlaps = is_closed & (first.0 <= last.0);
        let enters_between = (enter >= ends[0].0) & (enter <= ends[1].0);
        let leaves_between = (leave >= ends[0].0) & (leave <= ends[1].0);
        let (t, part) = first.or(is_closed, (enter, WALL));
        let (near, is_near_on_ray) = rounded_hit(ray, t, part);
        let (t, part) = last.or(is_closed, (leave, WALL));
        let (far, is_far_on_ray) = rounded_hit(ray, t, part);
        let is_near = is_near_on_ray & (overlaps | (!is_closed & enters_between));
        let is_open = parts == Self::Open.number();
        let is_far = is_far_on_ray & (overlaps | (is_open & leaves_between));
        (near.or(is_near, far), is_near | is_far)
    }
}

/// The numbers of the parts in [`ShapeHit::u`].
pub(super) const WALL: f32 = 0.0;
pub(super) const BASE: f32 = 1.0;
const TOP: f32 = 2.0;

impl CylinderDesc {
    /// A point of the shape.
    pub fn anchor(&self) -> Option<DVec3> {
        Some(self.base.0)
    }

    pub fn compile(&self, origin: DVec3) -> Result<Cylinder, Problem> {
        Ok(Cylinder {
            base: self.base.relative_to(origin),
            axis: Axis::new(self.axis.0),
            radius: self.radius.0,
            height: self.height.0,
            parts: Parts::compile(self.caps, self.outside_only.as_ref())?,
        })
    }
}

/// A cylinder, its wall alone or with caps.
#[derive(Clone, Copy, Debug)]
pub struct Cylinder {
    base: Vec3,
    radius: f32,
    height: f32,
    parts: Parts,
    axis: Axis,
}

impl Cylinder {
    /// The areas of wall, base and top, in m^2.
    fn areas(&self) -> [f64; 3] {
        let (r, h) = (f64::from(self.radius), f64::from(self.height));
        let cap = if self.parts == Parts::Closed { PI * r * r } else { 0.0 };
        [TAU * r * h, cap, cap]
    }

    /// Per m^2.
    fn per_area(&self) -> f64 {
        1.0 / self.areas().iter().sum::<f64>()
    }

    fn top(&self) -> DVec3 {
        self.base.as_dvec3() + self.axis.0 * f64::from(self.height)
    }

    fn contains(&self, p: Vec3) -> bool {
        let q = p.as_dvec3() - self.base.as_dvec3();
        let (z, r) = (q.dot(self.axis.0), f64::from(self.radius));
        z >= 0.0 && z <= self.height.into() && self.axis.across(q).length_squared() <= r * r
    }

    fn wall_surface(&self, q: DVec3) -> LocalSurface {
        let (r, h) = (f64::from(self.radius), f64::from(self.height));
        let z = q.dot(self.axis.0).clamp(0.0, h);
        let (e, _) = self.axis.outwards(q);
        let base = self.base.as_dvec3();
        let (p, p_error) = rounded(base + self.axis.0 * z + e * r, base.abs().max_element() + r + h);
        LocalSurface {
            p,
            p_error,
            ng: e.as_vec3(),
            uv: Vec2::new(self.axis.turn(e), (z / h) as f32),
            dpdu: (self.axis.tangent(e) * (TAU * r)).as_vec3(),
            dpdv: (self.axis.0 * h).as_vec3(),
        }
    }
}

impl BlockKind<9> for Cylinder {
    #[inline(always)]
    fn numbers(&self) -> [f64; 9] {
        let (b, w) = (self.base.as_dvec3(), self.axis.0);
        let (r, h) = (self.radius.into(), self.height.into());
        [b.x, b.y, b.z, w.x, w.y, w.z, r, h, self.parts.number()]
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

impl ShapeKind for Cylinder {
    fn curvature(&self) -> f32 {
        1.0 / self.radius
    }

    fn bounds(&self) -> Aabb {
        let base = disk_bounds(self.axis, self.base.as_dvec3(), self.radius);
        base.union(disk_bounds(self.axis, self.top(), self.radius))
    }

    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        intersect_one(self, ray)
    }

    fn block_numbers(&self) -> Numbers {
        numbers(self)
    }

    fn attempt_block(&self, on: impl Dispatch, block: &mut RayBlock<'_>) {
        block.attempt::<Self, _>(on);
    }

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> LocalSurface {
        let q = point_of(ray, hit) - self.base.as_dvec3();
        if hit.u == WALL {
            return self.wall_surface(q);
        }
        let (e, rho) = self.axis.outwards(q);
        let rho = rho.min(self.radius.into());
        if hit.u == TOP {
            return polar_surface(self.axis, self.top(), self.radius, e, rho);
        }
        let base = polar_surface(self.axis, self.base.as_dvec3(), self.radius, e, rho);
        LocalSurface { ng: -base.ng, ..base }
    }

    fn area(&self) -> f32 {
        (1.0 / self.per_area()) as f32
    }

    fn sample(&self, from: Vec3, u: Vec2) -> Option<ShapeSample> {
        let (part, ux) = choose(&self.areas(), u.x);
        let turn = f64::from(u.y);
        let base = self.base.as_dvec3();
        let (p, ng) = match part {
            0 => {
                let e = self.axis.ring(turn);
                let z = ux * f64::from(self.height);
                (base + self.axis.0 * z + e * f64::from(self.radius), e)
            }
            1 => (base + disk_point(self.axis, self.radius, ux, turn), -self.axis.0),
            _ => (self.top() + disk_point(self.axis, self.radius, ux, turn), self.axis.0),
        };
        let away = ng.dot(from.as_dvec3() - p) <= 0.0;
        if away && self.parts.hide(|| self.contains(from)) {
            return None;
        }
        area_sample(self.per_area(), from, p, ng)
    }

    fn pdf(&self, from: Vec3, wi: Vec3, hit: &ShapeHit) -> f32 {
        let s = self.surface(&Ray::new(from, wi), hit);
        solid_angle_pdf(self.per_area(), from.as_dvec3(), s.p.as_dvec3(), s.ng.as_dvec3())
    }
}
