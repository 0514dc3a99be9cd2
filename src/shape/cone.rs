//! A right circular cone, open or with a cap on its base.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `base` | centre of the base, `[x, y, z]` | m | `[0, 0, 0]` |
//! | `axis` | direction from the base to the apex | | `[0, 1, 0]` |
//! | `radius` | number above 0 | m | required |
//! | `height` | number above 0 | m | required |
//! | `caps` | whether the base is closed | | `true` |
//! | `outside_only` | whether only rays that enter the wall meet it; needs `caps = false` | | `false` |
//!
//! ```toml
//! shape.cone = { base = [0, 0, 0], axis = [0, 1, 0], radius = 0.5, height = 2 }
//! ```
//!
//! The apex is at `base + axis * height`. Normals point outwards, also where a ray meets the wall from inside; at the apex
//! itself the normal is one of the wall's. On the wall `u` runs around the axis in `[0, 1)`, for an axis of +y from +x
//! towards +z, and `v` from the base (0) to the apex (1); on the cap `u` is the same and `v` runs from the centre (0) to the
//! rim (1).
//!
//! With `outside_only` the wall is invisible from inside.
//!
//! # Implementation
//!
//! A line is inside an infinite cone for one interval, because the cone is convex; the cap clips it, and a ray meets the
//! cone where it enters or leaves the rest. The quadratic is solved around the point of the line that is nearest to the
//! apex, so that it does not cancel however far the ray has come, and in the form that stays finite for lines parallel to
//! the wall, where it is linear. Points are sampled uniformly by area; those on the far side of a closed cone are rejected.

use std::f64::consts::{PI, TAU};

use serde::Deserialize;

use super::{
    LocalSurface, ShapeHit, ShapeKind, ShapeSample,
    axis::Axis,
    block::{Attempt, BlockKind, intersected_in_blocks, vector},
    numeric::{Or, choose, dot_direction, point_of, rounded, solid_angle_pdf},
    round::{BASE, Parts, Round, RoundDesc, WALL},
};
use crate::{
    math::{Aabb, DVec3, Ray, Vec2, Vec3},
    value::Problem,
};

/// The description of a cone in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub struct ConeDesc(RoundDesc);

impl ConeDesc {
    /// A point of the shape.
    pub fn anchor(&self) -> Option<DVec3> {
        self.0.anchor()
    }

    pub fn compile(&self, origin: DVec3) -> Result<Cone, Problem> {
        self.0.compile(origin).map(Cone)
    }
}

/// A cone, its wall alone or with its cap.
#[derive(Clone, Copy, Debug)]
pub struct Cone(Round);

impl Cone {
    fn slant(&self) -> f64 {
        let (r, h) = (f64::from(self.0.radius), f64::from(self.0.height));
        (r * r + h * h).sqrt()
    }

    /// The areas of wall and base, in m^2.
    fn areas(&self) -> [f64; 2] {
        [PI * f64::from(self.0.radius) * self.slant(), self.0.cap_area()]
    }

    /// Per m^2.
    fn per_area(&self) -> f64 {
        1.0 / self.areas().iter().sum::<f64>()
    }

    fn contains(&self, p: Vec3) -> bool {
        let q = p.as_dvec3() - self.0.base.as_dvec3();
        let (z, h) = (q.dot(self.0.axis.0), f64::from(self.0.height));
        z >= 0.0 && z <= h && self.0.axis.across(q).length() <= f64::from(self.0.radius) * (1.0 - z / h)
    }

    /// The wall's normal on the side of `e`.
    fn wall_normal(&self, e: DVec3) -> DVec3 {
        (e * f64::from(self.0.height) + self.0.axis.0 * f64::from(self.0.radius)) / self.slant()
    }

    fn wall_surface(&self, q: DVec3) -> LocalSurface {
        let (r, h) = (f64::from(self.0.radius), f64::from(self.0.height));
        let z = q.dot(self.0.axis.0).clamp(0.0, h);
        let (e, _) = self.0.axis.outwards(q);
        let rho = r * (1.0 - z / h);
        let base = self.0.base.as_dvec3();
        let (p, p_error) = rounded(base + self.0.axis.0 * z + e * rho, base.abs().max_element() + r + h);
        let along = rho.max(r * f64::from(f32::EPSILON)) * TAU;
        LocalSurface {
            p,
            p_error,
            ng: self.wall_normal(e).as_vec3(),
            uv: Vec2::new(self.0.axis.turn(e), (z / h) as f32),
            dpdu: (self.0.axis.tangent(e) * along).as_vec3(),
            dpdv: (self.0.axis.0 * h - e * r).as_vec3(),
        }
    }
}

impl BlockKind<12> for Cone {
    #[inline(always)]
    fn numbers(&self) -> [f64; 12] {
        let (b, w, tip) = (self.0.base.as_dvec3(), self.0.axis.0, self.0.top());
        let (r, h) = (self.0.radius.into(), self.0.height.into());
        [
            b.x,
            b.y,
            b.z,
            w.x,
            w.y,
            w.z,
            tip.x,
            tip.y,
            tip.z,
            r,
            h,
            self.0.parts.number(),
        ]
    }

    #[inline(always)]
    fn attempt(numbers: &[f64; 12], ray: &Ray) -> Attempt {
        let (base, axis, apex) = (vector(numbers, 0), Axis(vector(numbers, 3)), vector(numbers, 6));
        let [.., r, h, parts] = *numbers;
        let (never, ever) = (f64::NEG_INFINITY, f64::INFINITY);
        let d = ray.d.as_dvec3();
        let from_apex = ray.o.as_dvec3() - apex;
        let shift = -from_apex.dot(d) / d.length_squared();
        let m = from_apex + d * shift;
        // Depths below the apex times the radius, and distances from the axis times the height:
        // equal on the wall.
        let (m_depth, d_depth) = (-m.dot(axis.0) * r, -d.dot(axis.0) * r);
        let (m_across, d_across) = (axis.across(m) * h, axis.across(d) * h);
        let a = d_across.length_squared() - d_depth * d_depth;
        let b = m_across.dot(d_across) - m_depth * d_depth;
        let c = m_across.length_squared() - m_depth * m_depth;
        let discriminant = b * b - a * c;
        let q = -(b + discriminant.max(0.0).sqrt().copysign(b));
        let (s, l) = (q / a, c / q).or(q != 0.0, (0.0, 0.0));
        let (first, second) = (s, l).or(s < l, (l, s));
        // The stretch inside the endless cone below the apex. A line steeper than the wall always meets it: rounding alone
        // makes its discriminant negative. One as steep as the wall meets it once.
        let (is_flat, is_steep, goes_down) = (a > 0.0, a < 0.0, d_depth > 0.0);
        let is_below = m_depth + d_depth * (0.5 * (first + second)) >= 0.0;
        let (down, up) = (second.or(is_steep, l), first.or(is_steep, l));
        let endless = (down, ever).or(goes_down, (never, up));
        let (enter, leave) = (first, second).or(is_flat, endless);
        let meets_once = (goes_down & (b < 0.0)) | (!goes_down & (b > 0.0));
        let meets_wall = (is_flat & is_below & (discriminant >= 0.0)) | is_steep | (!is_flat & meets_once);
        // The stretch above the base; its other end is no part of the cone.
        let (along, at) = (dot_direction(ray.d, axis.0), (ray.o.as_dvec3() - base).dot(axis.0));
        let (rises, falls) = (along > 0.0, along < 0.0);
        let end = (-at / along, BASE);
        let ends = [end.or(rises, (never, WALL)), end.or(falls, (ever, WALL))];
        let meets_ends = rises | falls | (at >= 0.0);
        let (hit, meets) = Parts::hit(parts, ray, [enter + shift, leave + shift], ends);
        Attempt::of(hit, meets & meets_wall & meets_ends)
    }
}

impl ShapeKind for Cone {
    /// The curvature at the base; towards the apex it is larger.
    fn curvature(&self) -> f32 {
        1.0 / self.0.radius
    }

    fn bounds(&self) -> Aabb {
        self.0.base_bounds().extended(self.0.top().as_vec3()).padded(1.0)
    }

    intersected_in_blocks!();

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> LocalSurface {
        let q = point_of(ray, hit) - self.0.base.as_dvec3();
        if hit.u == WALL {
            self.wall_surface(q)
        } else {
            self.0.base_surface(q)
        }
    }

    fn area(&self) -> f32 {
        (1.0 / self.per_area()) as f32
    }

    fn sample(&self, from: Vec3, u: Vec2) -> Option<ShapeSample> {
        let (part, ux) = choose(&self.areas(), u.x);
        let turn = f64::from(u.y);
        let base = self.0.base.as_dvec3();
        let point = if part == 0 {
            let e = self.0.axis.ring(turn);
            let from_apex = ux.sqrt();
            let z = f64::from(self.0.height) * (1.0 - from_apex);
            let rho = f64::from(self.0.radius) * from_apex;
            (base + self.0.axis.0 * z + e * rho, self.wall_normal(e))
        } else {
            (self.0.cap_point(base, ux, turn), -self.0.axis.0)
        };
        self.0.sample(self.per_area(), from, point, || self.contains(from))
    }

    fn pdf(&self, from: Vec3, wi: Vec3, hit: &ShapeHit) -> f32 {
        let s = self.surface(&Ray::new(from, wi), hit);
        solid_angle_pdf(self.per_area(), from.as_dvec3(), s.p.as_dvec3(), s.ng.as_dvec3())
    }
}
