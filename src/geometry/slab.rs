//! Intersection of rays and boxes, with a bound on every rounding error.
//!
//! One rule makes all accelerators agree: **a hit is clipped to the bounds of its primitive.**
//! [`Slabs::clip`] clamps the `t` of a hit to the interval of the ray that lies in the bounds, and
//! rejects the hit if the interval is empty. Without this rule, the `t` of a ray that grazes a
//! sliver is noise. It may lie far before the bounds of the sliver, and whether the hit is found
//! would depend on which boxes are traversed.
//!
//! With this rule, a tree cannot lose a hit: the interval of the ray in any box around a primitive
//! contains the interval in the bounds of the primitive. This holds in exact arithmetic.
//! [`Planes`], the ray as trees cull with it, is padded so that it holds in floating-point
//! arithmetic as well, with or without fused multiply-add. The margins, in units of
//! [`f32::EPSILON`], are: clipping widens the interval by 8 relative to `t` on both sides; culling
//! widens it by 48 relative to the exit distance, by 24 relative to the ray's end, and by 4
//! relative to the ray's origin. Rounding the distance to a plane causes errors of less than 2
//! relative to `t` and 2 relative to the origin.
//!
//! Directions are not clamped. A component of zero gets a reciprocal of its own sign that is large
//! enough for all valid coordinates ([`crate::geometry::MAX_COORDINATE`]), so `0 * inf` never
//! occurs.

use super::padding::BoundsPadding;
use crate::math::{Aabb, Ray, Vec3};

/// The slack of clipping to a primitive's bounds, relative to `t`.
pub(crate) const CLIP_SLACK: f32 = 8.0 * f32::EPSILON;

/// The largest relative error of a triangle's `t`. A hit that clipping would move farther is
/// rejected: the ray runs within 10^-4 rad of the triangle's plane, or starts in it.
pub(crate) const MAX_T_NOISE: f32 = 1.0 / 1024.0;

/// A distance below everything that is modelled, in metres. It keeps rays inside a box that run in
/// one of its faces.
pub(crate) const MIN_PADDING: f32 = 1e-20;

/// The largest reciprocal, for directions whose largest component is 1.
pub(crate) const MAX_RECIPROCAL: f32 = 1e30;

/// The padding of culling: a factor for the exit distance, and the next one for the ray's end.
pub(crate) const EXIT_PADDING: f32 = 1.0 + 48.0 * f32::EPSILON;
pub(crate) const END_PADDING: f32 = 1.0 + 24.0 * f32::EPSILON;

/// The padding relative to a ray's origin.
pub(crate) const ORIGIN_PADDING: f32 = 4.0 * f32::EPSILON;

/// Returns the reciprocals of the components, or NaN for a ray that is degenerate or not finite.
/// Such a ray hits nothing.
#[inline]
pub(crate) fn reciprocal(ray: &Ray) -> Vec3 {
    let largest = ray.d.abs().max_element();
    if !(largest > 0.0 && ray.d.is_finite() && ray.o.is_finite()) {
        return Vec3::NAN;
    }
    let steepest = (MAX_RECIPROCAL / largest).min(f32::MAX);
    ray.d.map(|d| {
        if d.abs() * steepest > 1.0 {
            1.0 / d
        } else {
            steepest.copysign(d)
        }
    })
}

/// A ray as it is clipped to the bounds of a primitive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slabs {
    pub o: Vec3,
    /// [`reciprocal`].
    pub inv: Vec3,
}

impl Slabs {
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        Self {
            o: ray.o,
            inv: reciprocal(ray),
        }
    }

    /// Clamps `t` to the interval of the ray in `own`; returns `None` if the ray misses `own`.
    ///
    /// The kernels do the same operations in the same order, see `accel::kernels`.
    #[inline]
    pub fn clip(&self, t: f32, own: &Aabb) -> Option<f32> {
        let (t, meets) = self.clamp(t, own);
        meets.then_some(t)
    }

    /// Does the same without branches; the second result is whether the ray intersects `own`.
    #[inline(always)]
    pub fn clamp(&self, t: f32, own: &Aabb) -> (f32, bool) {
        let mut enter = f32::NEG_INFINITY;
        let mut leave = f32::INFINITY;
        for axis in 0..3 {
            let (o, inv) = (self.o[axis], self.inv[axis]);
            let tiny = MIN_PADDING.copysign(inv);
            let (first, last) = if inv > 0.0 {
                (own.min[axis], own.max[axis])
            } else {
                (own.max[axis], own.min[axis])
            };
            let near = ((first - o) - tiny) * inv;
            let far = ((last - o) + tiny) * inv;
            enter = if near > enter { near } else { enter };
            leave = if far < leave { far } else { leave };
        }
        let enter = enter - enter.abs() * CLIP_SLACK;
        let leave = leave + leave.abs() * CLIP_SLACK;
        let meets = (enter <= leave) & self.inv.x.is_finite();
        let t = if t > enter { t } else { enter };
        let t = if t < leave { t } else { leave };
        // The addition avoids a negative zero, which equals the positive one but has other bits.
        (t + 0.0, meets)
    }

    /// Does the same for a triangle, whose `t` may be noise.
    #[inline]
    pub fn clip_triangle(&self, t: f32, own: &Aabb) -> Option<f32> {
        let clipped = self.clip(t, own)?;
        ((clipped - t).abs() <= t.abs() * MAX_T_NOISE && t.is_finite()).then_some(clipped)
    }
}

/// A ray as trees cull with it: the distance to the plane `x = b` of a box is `b * inv - shift`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Planes {
    /// [`reciprocal`].
    pub inv: Vec3,
    /// For the planes through which the ray enters boxes, with the origin moved forward.
    pub shift_near: Vec3,
    /// For the planes through which the ray leaves boxes, with the origin moved back.
    pub shift_far: Vec3,
    /// Whether the ray enters boxes through their upper side.
    pub negative: [bool; 3],
    /// Whether the ray can hit anything at all.
    pub can_hit: bool,
}

impl Planes {
    #[inline]
    pub fn new(ray: &Ray, padding: BoundsPadding) -> Self {
        let inv = reciprocal(ray);
        // The factors widen towards larger |t| only, which is the wrong direction behind the
        // origin.
        let pad = if ray.tmin >= 0.0 {
            ray.o.abs() * ORIGIN_PADDING + 4.0 * MIN_PADDING
        } else {
            (ray.o.abs() + padding.reach) * (32.0 * ORIGIN_PADDING) + 4.0 * MIN_PADDING
        };
        let away = ray.o.abs().max_element();
        let pad = (pad + away * padding.origin) * inv.signum();
        let mut planes = Self {
            inv,
            shift_near: (ray.o + pad) * inv,
            shift_far: (ray.o - pad) * inv,
            negative: [inv.x < 0.0, inv.y < 0.0, inv.z < 0.0],
            can_hit: inv.x.is_finite(),
        };
        // If the origin is so far away that a plane's distance overflows, every box passes.
        for axis in 0..3 {
            if !(planes.shift_near[axis].is_finite() && planes.shift_far[axis].is_finite()) {
                planes.shift_near[axis] = f32::INFINITY;
                planes.shift_far[axis] = f32::NEG_INFINITY;
            }
        }
        planes
    }

    /// Returns a lower bound of the entry distance of `b`, if the ray may intersect it between
    /// `tmin` and `tmax`.
    #[inline]
    pub fn enter(&self, b: &Aabb, tmin: f32, tmax: f32) -> Option<f32> {
        let (mut enter, mut leave) = (tmin, f32::INFINITY);
        for axis in 0..3 {
            let (near, far) = if self.negative[axis] {
                (b.max[axis], b.min[axis])
            } else {
                (b.min[axis], b.max[axis])
            };
            let near = near * self.inv[axis] - self.shift_near[axis];
            let far = far * self.inv[axis] - self.shift_far[axis];
            enter = if near > enter { near } else { enter };
            leave = if far < leave { far } else { leave };
        }
        (self.can_hit && enter <= leave * EXIT_PADDING && enter <= tmax * END_PADDING)
            .then_some(enter - enter.abs() * (END_PADDING - 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For a scene without instances.
    fn planes(ray: &Ray, reach: f32) -> Planes {
        Planes::new(ray, BoundsPadding { reach, origin: 0.0 })
    }

    fn unit_box() -> Aabb {
        Aabb {
            min: Vec3::ZERO,
            max: Vec3::ONE,
        }
    }

    #[test]
    fn rays_in_a_face_or_along_an_edge_are_inside() {
        for o in [
            Vec3::new(0.0, 0.5, -2.0),
            Vec3::new(1.0, 1.0, -2.0),
            Vec3::new(0.0, 0.0, -2.0),
        ] {
            for zero in [0.0, -0.0] {
                let ray = Ray::new(o, Vec3::new(zero, zero, 1.0));
                assert_eq!(Slabs::new(&ray).clip(2.5, &unit_box()), Some(2.5));
                assert!(planes(&ray, 1.0).enter(&unit_box(), 0.0, f32::INFINITY).is_some());
            }
        }
        let beside = Ray::new(Vec3::new(1.001, 0.5, -2.0), Vec3::Z);
        assert_eq!(Slabs::new(&beside).clip(2.5, &unit_box()), None);
        assert!(planes(&beside, 1.0).enter(&unit_box(), 0.0, f32::INFINITY).is_none());
    }

    #[test]
    fn noise_in_t_is_brought_into_the_box() {
        let ray = Ray::new(Vec3::new(0.5, 0.5, -2.0), Vec3::Z);
        assert_eq!(Slabs::new(&ray).clip_triangle(0.1, &unit_box()), None);
        assert!(
            Slabs::new(&ray)
                .clip_triangle(1.999, &unit_box())
                .is_some_and(|t| (t - 2.0).abs() < 1e-5)
        );
        let near = Slabs::new(&ray).clip(0.1, &unit_box()).expect("the ray meets the box");
        let far = Slabs::new(&ray).clip(9.0, &unit_box()).expect("the ray meets the box");
        assert!((near - 2.0).abs() < 1e-5 && (far - 3.0).abs() < 1e-5);
    }

    #[test]
    fn rays_that_are_not_finite_meet_nothing() {
        for d in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
            let ray = Ray::new(Vec3::splat(0.5), d);
            assert_eq!(Slabs::new(&ray).clip(0.5, &unit_box()), None);
            assert!(planes(&ray, 1.0).enter(&unit_box(), 0.0, 1.0).is_none());
        }
    }

    #[test]
    fn distances_that_overflow_do_not_hide_a_box() {
        let ray = Ray::new(Vec3::new(5e8, -5e8, -3e9), Vec3::Z);
        let large = Aabb {
            min: Vec3::splat(-1e9),
            max: Vec3::splat(1e9),
        };
        assert!(planes(&ray, 1e9).enter(&large, 0.0, f32::INFINITY).is_some());
        assert!(Slabs::new(&ray).clip(2.5e9, &large).is_some());
    }
}
