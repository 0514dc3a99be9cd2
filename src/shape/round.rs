//! The common part of cylinders and cones: a wall around an axis, open or with caps.

use std::f64::consts::PI;

use serde::Deserialize;

use super::{
    LocalSurface, ShapeHit, ShapeSample,
    axis::Axis,
    disk::{disk_bounds, disk_point, polar_surface},
    numeric::{Or, area_sample, rounded_hit},
};
use crate::{
    math::{Aabb, DVec3, Ray, Vec3},
    value::{Direction, Point, Positive, Problem, Spanned},
};

/// The description of a wall around an axis in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoundDesc {
    #[serde(default)]
    base: Point,
    #[serde(default = "Direction::up")]
    axis: Direction,
    radius: Positive,
    height: Positive,
    #[serde(default = "yes")]
    caps: bool,
    #[serde(default)]
    outside_only: Option<Spanned<bool>>,
}

fn yes() -> bool {
    true
}

impl RoundDesc {
    /// A point of the shape.
    pub fn anchor(&self) -> Option<DVec3> {
        Some(self.base.0)
    }

    pub fn compile(&self, origin: DVec3) -> Result<Round, Problem> {
        Ok(Round {
            base: self.base.relative_to(origin),
            axis: Axis::new(self.axis.0),
            radius: self.radius.0,
            height: self.height.0,
            parts: Parts::compile(self.caps, self.outside_only.as_ref())?,
        })
    }
}

/// A wall around an axis, alone or with its caps.
#[derive(Clone, Copy, Debug)]
pub struct Round {
    pub(super) base: Vec3,
    pub(super) radius: f32,
    pub(super) height: f32,
    pub(super) parts: Parts,
    pub(super) axis: Axis,
}

impl Round {
    /// The centre of the top; the apex of a cone.
    pub(super) fn top(&self) -> DVec3 {
        self.base.as_dvec3() + self.axis.0 * f64::from(self.height)
    }

    /// The area of a cap, in m^2.
    pub(super) fn cap_area(&self) -> f64 {
        let r = f64::from(self.radius);
        if self.parts == Parts::Closed { PI * r * r } else { 0.0 }
    }

    pub(super) fn base_bounds(&self) -> Aabb {
        disk_bounds(self.axis, self.base.as_dvec3(), self.radius)
    }

    /// The surface of the cap on the base at `q` from its centre.
    pub(super) fn base_surface(&self, q: DVec3) -> LocalSurface {
        let cap = self.cap_surface(self.base.as_dvec3(), q);
        LocalSurface { ng: -cap.ng, ..cap }
    }

    /// The surface of the cap around `center`, whose normal is the axis, at `q` from the centre of the base.
    pub(super) fn cap_surface(&self, center: DVec3, q: DVec3) -> LocalSurface {
        let (e, rho) = self.axis.outwards(q);
        polar_surface(self.axis, center, self.radius, e, rho.min(self.radius.into()))
    }

    /// A point of the cap around `center`, uniform by area.
    pub(super) fn cap_point(&self, center: DVec3, u: f64, turn: f64) -> DVec3 {
        center + disk_point(self.axis, self.radius, u, turn)
    }

    /// The sample of a point, which was chosen with the density m^-2 `per_area`, and its normal; `None` where it is hidden
    /// from `from`. `contains` says whether `from` is inside.
    pub(super) fn sample(
        &self,
        per_area: f64,
        from: Vec3,
        (p, ng): (DVec3, DVec3),
        contains: impl Fn() -> bool,
    ) -> Option<ShapeSample> {
        let away = ng.dot(from.as_dvec3() - p) <= 0.0;
        if away && self.parts.hide(contains) {
            return None;
        }
        area_sample(per_area, from, p, ng)
    }
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
pub(super) const TOP: f32 = 2.0;
