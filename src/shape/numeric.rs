//! Numerical routines that shapes share: roots on a ray, points rounded together with their bound,
//! and densities converted from area to solid angle.
//!
//! Hits are found in double precision. A [`ShapeHit`] keeps the root rounded to single precision in
//! `t` and what the rounding took away in `v`, so that
//! [`ShapeKind::surface`](super::ShapeKind::surface) finds the place again as precisely as it was
//! found, however far the ray has come; `u` tells the part that was hit.

use super::{ShapeHit, ShapeSample};
use crate::math::{DVec3, Ray, Vec3};

/// The hit of part `part` at `t`, where its rounded value lies on the ray.
#[inline]
pub(super) fn hit_at(ray: &Ray, t: f64, part: f32) -> Option<ShapeHit> {
    let (hit, on_ray) = rounded_hit(ray, t, part);
    on_ray.then_some(hit)
}

/// The same without branches; the second answer says whether it lies on the ray.
#[inline(always)]
pub(super) fn rounded_hit(ray: &Ray, t: f64, part: f32) -> (ShapeHit, bool) {
    let rounded = t as f32;
    let hit = ShapeHit {
        t: rounded,
        u: part,
        v: (t - f64::from(rounded)) as f32,
    };
    let on_ray = (rounded > ray.tmin) & (rounded <= ray.tmax) & rounded.is_finite();
    (hit, on_ray)
}

/// A choice between two values without a branch, for vectors.
pub(super) trait Or: Sized {
    /// `self` if `chosen`, else `other`.
    fn or(self, chosen: bool, other: Self) -> Self;
}

impl Or for f32 {
    #[inline(always)]
    fn or(self, chosen: bool, other: Self) -> Self {
        if chosen { self } else { other }
    }
}

impl Or for f64 {
    #[inline(always)]
    fn or(self, chosen: bool, other: Self) -> Self {
        if chosen { self } else { other }
    }
}

impl<A: Or, B: Or> Or for (A, B) {
    #[inline(always)]
    fn or(self, chosen: bool, other: Self) -> Self {
        (self.0.or(chosen, other.0), self.1.or(chosen, other.1))
    }
}

impl Or for ShapeHit {
    #[inline(always)]
    fn or(self, chosen: bool, other: Self) -> Self {
        Self {
            t: self.t.or(chosen, other.t),
            u: self.u.or(chosen, other.u),
            v: self.v.or(chosen, other.v),
        }
    }
}

/// The point where the ray met the shape, in double precision.
#[inline]
pub(super) fn point_of(ray: &Ray, hit: &ShapeHit) -> DVec3 {
    ray.o.as_dvec3() + ray.d.as_dvec3() * (f64::from(hit.t) + f64::from(hit.v))
}

/// `p` in single precision, and a bound on each coordinate's error.
///
/// The bound is a whole unit in the last place, twice what rounding can do: the other half pays for
/// a normal that is rounded as well. `extent` is the largest number that was added up to `p` in
/// double precision; its share is above 0, so that a ray leaves even a coordinate of exactly 0.
#[inline]
pub(super) fn rounded(p: DVec3, extent: f64) -> (Vec3, Vec3) {
    const OPERATIONS: f64 = 32.0;
    let single = p.as_vec3();
    let error = single.abs() * f32::EPSILON + (extent * OPERATIONS * f64::EPSILON) as f32;
    (single, error)
}

/// `d . n`, or 0 where the same product in single precision, as
/// [`offset_origins`](crate::math::float::offset_origins) computes it, has another sign.
///
/// A ray that left a flat surface to one side thus never comes back to it, not even a grazing one.
#[inline(always)]
pub(super) fn dot_direction(d: Vec3, n: DVec3) -> f64 {
    let exact = d.as_dvec3().dot(n);
    let seen = f64::from(d.dot(n.as_vec3()));
    if exact * seen > 0.0 { exact } else { 0.0 }
}

/// The density m^-2 `per_area` at `p`, turned into sr^-1 as seen from `from`; 0 where it has no
/// finite value.
#[inline(always)]
pub(super) fn solid_angle_pdf(per_area: f64, from: DVec3, p: DVec3, ng: DVec3) -> f32 {
    let to = p - from;
    let distance2 = to.length_squared();
    let pdf = (per_area * distance2 * distance2.sqrt() / ng.dot(to).abs()) as f32;
    if pdf.is_finite() { pdf } else { 0.0 }
}

/// A point chosen with the density m^-2 `per_area`, as seen from `from`; `None` where it is seen
/// edge-on.
pub(super) fn area_sample(per_area: f64, from: Vec3, p: DVec3, ng: DVec3) -> Option<ShapeSample> {
    let pdf = solid_angle_pdf(per_area, from.as_dvec3(), p, ng);
    (pdf > 0.0).then(|| ShapeSample {
        p: p.as_vec3(),
        ng: ng.as_vec3(),
        pdf,
    })
}

/// The number of one of `weights`, chosen in proportion to them, and what is left of `u`, in `[0,
/// 1)` again. Weights may be 0 and need not add up to 1.
pub(super) fn choose(weights: &[f64], u: f32) -> (usize, f64) {
    let total: f64 = weights.iter().sum();
    let mut left = f64::from(u) * total;
    let mut last = (0, 0.0);
    for (i, &w) in weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
        if left < w {
            return (i, left / w);
        }
        left -= w;
        last = (i, 1.0 - f64::EPSILON);
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hit_and_its_remainder_give_the_root_again() {
        let ray = Ray::new(Vec3::ZERO, Vec3::X);
        let hit = hit_at(&ray, 12_345.678_901_234, 0.0).unwrap();
        assert!((point_of(&ray, &hit).x - 12_345.678_901_234).abs() < 1e-9);
    }

    #[test]
    fn roots_off_the_ray_or_without_a_finite_value_are_no_hits() {
        let ray = Ray::new(Vec3::ZERO, Vec3::X);
        for t in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e39] {
            assert_eq!(hit_at(&ray, t, 0.0), None);
        }
        assert_eq!(hit_at(&Ray { tmin: 2.0, ..ray }, 2.0 + 1e-12, 0.0), None);
        assert!(hit_at(&Ray { tmax: 2.0, ..ray }, 2.0 + 1e-12, 0.0).is_some());
    }

    #[test]
    fn choices_follow_their_weights_and_never_fall_on_zero() {
        assert_eq!(choose(&[0.0, 1.0, 3.0, 0.0], 0.0), (1, 0.0));
        assert_eq!(choose(&[0.0, 1.0, 3.0, 0.0], 0.625), (2, 0.5));
        assert_eq!(choose(&[0.0, 1.0, 0.0], 1.0_f32.next_down()).0, 1);
    }
}
