//! A flat parallelogram, which rays are traced against as two triangles.

use super::triangle;
use crate::math::{Aabb, DVec3, Transform, Vec2, Vec3, float::gamma};

/// The least error of a point, relative to the largest coordinate, so that a ray leaves even a coordinate of exactly 0.
const LEAST_ERROR: f32 = 1e-14;

/// A parallelogram with the corners A, B, C and D, in order around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parallelogram {
    corners: [Vec3; 4],
    /// The vectors whose products with a point relative to A are its u, along AB, and its v, along AD.
    to_uv: [Vec3; 2],
    /// Unit.
    ng: Vec3,
    /// The part of [`FlatPlace::p_error`] that all points have.
    point_error: Vec3,
    /// See [`Parallelogram::plane_error`].
    plane_error: f32,
    bounds: Aabb,
}

/// A place on a parallelogram.
#[derive(Clone, Copy, Debug)]
pub struct FlatPlace {
    pub p: Vec3,
    /// Bound on the absolute error of each coordinate of `p`.
    pub p_error: Vec3,
    /// Unit.
    pub ng: Vec3,
    /// The part of the way from A to B and to D, each in `[0, 1]`.
    pub uv: Vec2,
}

impl Parallelogram {
    /// The parallelogram with these corners, up to the rounding of C, in the shape's own space.
    pub(super) fn new(corners: [Vec3; 4], to_uv: [DVec3; 2], ng: Vec3) -> Self {
        Self {
            corners,
            to_uv: to_uv.map(|v| v.as_vec3()),
            ng,
            point_error: point_error(corners),
            plane_error: largest_plane_error(corners),
            bounds: Aabb::from_points(corners),
        }
    }

    /// The triangles ABC and ACD.
    #[inline(always)]
    pub fn halves(&self) -> [[Vec3; 3]; 2] {
        let [a, b, c, d] = self.corners;
        [[a, b, c], [a, c, d]]
    }

    /// The place at a point that is nearly on it.
    #[inline(always)]
    pub fn place(&self, p: Vec3) -> FlatPlace {
        let uv = self.uv(p);
        let p = on_plane(p, self.corners[0], self.ng, &self.bounds);
        // Of most, which are level, it is less than the error of the point.
        let of_plane = if self.plane_error <= self.point_error.max_element() {
            self.plane_error
        } else {
            plane_error_at(self.corners, p).min(self.plane_error)
        };
        FlatPlace {
            p,
            p_error: self.point_error + self.ng.abs() * of_plane,
            ng: self.ng,
            uv,
        }
    }

    /// The same in world space, where the point is.
    #[inline(never)]
    pub fn place_in_world(&self, t: &Transform, p: Vec3) -> FlatPlace {
        let corners = self.corners.map(|p| t.point_to_world(p));
        let ng = t.normal_to_world(self.ng).normalize();
        let uv = self.uv(t.point_to_local(p));
        let p = on_plane(p, corners[0], ng, &Aabb::from_points(corners));
        FlatPlace {
            p,
            p_error: point_error(corners) + ng.abs() * plane_error_at(corners, p).min(largest_plane_error(corners)),
            ng,
            uv,
        }
    }

    /// Bound on the distance between the plane and any place where a ray meets the triangles; in world
    /// space if there is a transform to it.
    #[inline]
    pub fn plane_error(&self, t: Option<&Transform>) -> f32 {
        t.map_or(self.plane_error, |t| {
            largest_plane_error(self.corners.map(|p| t.point_to_world(p)))
        })
    }

    #[inline(always)]
    fn uv(&self, p: Vec3) -> Vec2 {
        let (h, [u, v]) = (p - self.corners[0], self.to_uv);
        Vec2::new(h.dot(u), h.dot(v)).clamp(Vec2::ZERO, Vec2::ONE)
    }
}

/// The point of the plane through `corner` that is nearest to `p`, and not beyond the edges of a wall along two axes. It is as
/// precise as `p`, which parameters of a large floor are not.
#[inline(always)]
fn on_plane(p: Vec3, corner: Vec3, ng: Vec3, bounds: &Aabb) -> Vec3 {
    (p + ng * (corner - p).dot(ng)).clamp(bounds.min, bounds.max)
}

/// Bound on the error of a point on the plane: of its coordinates, and of the rounding of C.
fn point_error([a, b, c, d]: [Vec3; 4]) -> Vec3 {
    let (e, f) = (b - a, d - a);
    let sum = a.abs() + e.abs() + f.abs();
    sum * gamma(4) + (c - b - f).abs() + sum.max_element() * LEAST_ERROR
}

/// Bound on the distance between the plane and the place where a ray from `p`, a point on it, meets the triangles: the larger one
/// of the two, since a ray from one may be tested against the other.
fn plane_error_at([a, b, c, d]: [Vec3; 4], p: Vec3) -> f32 {
    let twice_area = (b - a).cross(d - a).length();
    let of = |triangle| triangle::plane_error(triangle, p, twice_area);
    of([a, b, c]).max(of([a, c, d]))
}

/// The same of all points.
fn largest_plane_error([a, b, _, d]: [Vec3; 4]) -> f32 {
    let (e, f) = (b - a, d - a);
    let (widest, twice_area) = (e.abs() + f.abs(), e.cross(f).length());
    let error = 12.0 * gamma(10) * (widest.x * widest.y * widest.z / twice_area);
    // Of a needle it ends at the needle's width.
    error.min(twice_area / e.length().max(f.length()))
}
