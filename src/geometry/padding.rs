//! How far roundings carry a ray that is mapped into an instance's space.
//!
//! A hit in an instance is decided in the space of its group alone: by the mapped ray, the triangle and the triangle's
//! own box ([`super::slab`]). The trees above cull in world space. They lose no hit as long as every box around an
//! instance is so wide that the point of the *world* ray at each `t` that can be a hit lies in it.
//!
//! With W and M the matrices of the map and of its inverse, and |.| for the absolute numbers of a matrix, a point
//! `o + t d` of the ray and the map of the corresponding point in local space lie apart by less than
//!
//! `eps (12 K |o| + 11 K |box| + 3 B)`, where `K = max |W| |M| 1` and `B = max (|W| |m| + |w|)`
//!
//! ([`Transform::magnification`]): four roundings for the mapped origin, three for the direction, one each for the
//! numbers of both matrices, and the slack of eight of the rule about the own box. [`bounds`] widens an instance's box
//! by what depends on the instance, trees of scenes with instances widen all boxes by what depends on a ray's origin
//! ([`BoundsPadding`]).

use crate::math::{Aabb, DVec3, Transform, Vec3};

/// The factor that stands for 12, 11 and 3 above, with some room.
const ROUNDINGS: f32 = 16.0 * f32::EPSILON;

/// Maps that magnify roundings by more than this are worth a copy of the mesh in world space: the trees of a scene are
/// widened for its worst instance.
pub const MAX_MAGNIFICATION: f32 = 64.0;

/// How a tree's boxes are widened for a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct BoundsPadding {
    /// The largest coordinate of all boxes, and of those of groups in their own spaces.
    pub reach: f32,
    /// The part of the largest coordinate of a ray's origin; zero where there are no instances.
    pub origin: f32,
}

impl BoundsPadding {
    /// What a scene needs with instances at these places, of which all boxes have coordinates of up to `reach`.
    pub fn new<'a>(instances: impl Iterator<Item = &'a Transform>, reach: f32) -> Self {
        let origin = instances.map(|placed| ROUNDINGS * placed.magnification().0);
        Self {
            reach,
            origin: origin.fold(0.0, f32::max),
        }
    }

    /// Inside a group there is nothing further to be mapped.
    pub fn inside(self) -> Self {
        Self { origin: 0.0, ..self }
    }
}

/// The world-space box of an instance whose group has the box `local`.
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
