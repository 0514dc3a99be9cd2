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
    disk::{disk_bounds, disk_point, polar_surface},
    numeric::{area_sample, choose, dot_direction, hit_at, point_of, rounded, solid_angle_pdf},
};
use crate::{
    math::{Aabb, DVec3, Ray, Vec2, Vec3},
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

    /// The hit, of where the ray enters and leaves the wall and where it enters and leaves what
    /// lies between the ends; each with its part's number.
    #[inline]
    pub fn hit(self, ray: &Ray, wall: [f64; 2], ends: [(f64, f32); 2]) -> Option<ShapeHit> {
        let [enter, leave] = wall;
        if self == Self::Closed {
            let first = if enter >= ends[0].0 { (enter, WALL) } else { ends[0] };
            let last = if leave <= ends[1].0 { (leave, WALL) } else { ends[1] };
            if first.0 > last.0 {
                return None;
            }
            return hit_at(ray, first.0, first.1).or_else(|| hit_at(ray, last.0, last.1));
        }
        let at = |t: f64| (t >= ends[0].0 && t <= ends[1].0).then(|| hit_at(ray, t, WALL))?;
        at(enter).or_else(|| if self == Self::Open { at(leave) } else { None })
    }
}

/// The numbers of the parts in [`ShapeHit::u`].
pub(super) const WALL: f32 = 0.0;
pub(super) const BASE: f32 = 1.0;
const TOP: f32 = 2.0;

impl CylinderDesc {
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
    /// The stretch of a line inside the endless cylinder.
    #[inline]
    fn inside_wall(&self, q: DVec3, d: DVec3) -> Option<[f64; 2]> {
        let (q, d) = (self.axis.across(q), self.axis.across(d));
        let r = f64::from(self.radius);
        let a = d.length_squared();
        if a == 0.0 {
            return (q.length_squared() <= r * r).then_some([f64::NEG_INFINITY, f64::INFINITY]);
        }
        let closest_t = -q.dot(d) / a;
        let h2 = r * r - (q + d * closest_t).length_squared();
        (h2 >= 0.0).then(|| {
            let half = (h2 / a).sqrt();
            [closest_t - half, closest_t + half]
        })
    }

    /// The stretch of a line between the two end planes, each end with the number of its part.
    #[inline]
    fn between_ends(&self, ray: &Ray, q: DVec3) -> Option<[(f64, f32); 2]> {
        let (along, at) = (dot_direction(ray.d, self.axis.0), q.dot(self.axis.0));
        let height = f64::from(self.height);
        if along == 0.0 {
            let between = at >= 0.0 && at <= height;
            return between.then_some([(f64::NEG_INFINITY, BASE), (f64::INFINITY, TOP)]);
        }
        let (base, top) = ((-at / along, BASE), ((height - at) / along, TOP));
        Some(if along > 0.0 { [base, top] } else { [top, base] })
    }

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
        let q = ray.o.as_dvec3() - self.base.as_dvec3();
        let wall = self.inside_wall(q, ray.d.as_dvec3())?;
        let ends = self.between_ends(ray, q)?;
        self.parts.hit(ray, wall, ends)
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
