//! A bound on the rounding error of rays that are transformed to an instance's local space.
//!
//! A hit on an instance is computed in local space only: from the transformed ray, the triangle and
//! the triangle's bounds ([`super::slab`]). The trees above cull in world space. They lose no hit
//! if every box around an instance is so large that it contains the point of the *world-space* ray
//! at every `t` of a possible hit.
//!
//! Let W and M be the matrices of the transform and of its inverse, and |.| the matrix of absolute
//! values. The distance between a point `o + t d` of the ray and the transformed point in local
//! space is less than
//!
//! `eps (12 K |o| + 11 K |box| + 3 B)`, where `K = max |W| |M| 1` and `B = max (|W| |m| + |w|)`
//!
//! ([`Transform::magnification`]). The terms are four roundings for the transformed origin, three
//! for the direction, one each for the elements of both matrices, and the slack of eight of
//! clipping. [`bounds`] pads the bounds of an instance by the terms that depend on the instance.
//! Trees of scenes with instances pad all boxes by the term that depends on the ray's origin
//! ([`BoundsPadding`]).

use crate::math::{Aabb, DVec3, Transform, Vec3};

/// The factor in place of 12, 11 and 3 above, with a margin.
const ROUNDINGS: f32 = 16.0 * f32::EPSILON;

/// The largest magnification of rounding errors for which a mesh should be instanced. Beyond it, a
/// copy of the mesh in world space is better, since all boxes of a scene are padded for its worst
/// instance.
pub const MAX_MAGNIFICATION: f32 = 64.0;

/// The padding of a tree's boxes for a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct BoundsPadding {
    /// The largest coordinate of all boxes, including those of groups in local space.
    pub reach: f32,
    /// The padding relative to the largest coordinate of a ray's origin; zero if there are no
    /// instances.
    pub origin: f32,
}

impl BoundsPadding {
    /// Returns the padding for a scene with these instances, whose boxes have coordinates of at
    /// most `reach`.
    pub fn new<'a>(instances: impl Iterator<Item = &'a Transform>, reach: f32) -> Self {
        let origin = instances.map(|placed| ROUNDINGS * placed.magnification().0);
        Self {
            reach,
            origin: origin.fold(0.0, f32::max),
        }
    }

    /// Returns the padding inside of a group, where no further transform follows.
    pub fn inside(self) -> Self {
        Self { origin: 0.0, ..self }
    }
}

/// Returns the world-space bounds of an instance whose group has the bounds `local`.
pub(crate) fn bounds(world_from_local: &Transform, local: &Aabb) -> Aabb {
    if local.is_empty() {
        return Aabb::EMPTY;
    }
    let map = world_from_local.widened();
    let (center, half) = (
        local.min.as_dvec3() + local.max.as_dvec3(),
        local.max.as_dvec3() - local.min.as_dvec3(),
    );
    let (center, half) = (map.transform_point3(center * 0.5), half * 0.5);
    let m = map.matrix3;
    let half: DVec3 = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
    let (min, max) = ((center - half).as_vec3(), (center + half).as_vec3());
    let (k, b) = world_from_local.magnification();
    let largest = min.abs().max(max.abs()).max_element();
    let pad = Vec3::splat(ROUNDINGS * (k * largest + b));
    Aabb {
        min: min - pad,
        max: max + pad,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_holds_the_mapped_corners() {
        let t = Transform::from_parts(
            DVec3::new(1.0, -2.0, 3.0),
            DVec3::new(10.0, 20.0, 30.0),
            DVec3::new(-2.0, 0.5, 3.0),
        )
        .expect("invertible");
        let local = Aabb {
            min: Vec3::new(-1.0, 2.0, 0.0),
            max: Vec3::new(0.5, 2.0, 7.0),
        };
        let own = bounds(&t, &local);
        let corners = Aabb::from_points((0..8).map(|i| t.point_to_world(local.corner(i))));
        assert_eq!(own.union(corners), own);
        assert!((own.extent() - corners.extent()).abs().max_element() < 1e-3);
        let (k, _) = t.magnification();
        assert!(k > 1.0 && k < 4.0, "{k}");
        assert!(bounds(&t, &Aabb::EMPTY).is_empty());
    }
}
