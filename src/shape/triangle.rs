//! The triangle of a mesh: three corners that live in the mesh's arrays.

use super::ShapeHit;
use crate::math::{Ray, Vec3};

/// Where `ray` meets the triangle `a`, `b`, `c` with `ray.tmin < t <= ray.tmax`; `u` and `v` are the barycentric weights
/// of `b` and `c`.
///
/// Watertight: an edge's test depends on its two corners alone and flips its sign with their order, so a ray never
/// passes between two triangles that share the edge. Every accelerator computes these operations in this order,
/// without fused multiply-adds, so that all of them find the same bits.
///
/// Source: the edge test is the Pluecker form of Davis and Ferguson's that Woop describes, "A Ray Tracing Hardware
/// Architecture for Dynamic Scenes", 2004, with corners taken relative to the ray's origin.
#[inline]
pub fn intersect(ray: &Ray, a: Vec3, b: Vec3, c: Vec3) -> Option<ShapeHit> {
    let (a, b, c) = (a - ray.o, b - ray.o, c - ray.o);
    let (e0, e1, e2) = (c - b, a - c, b - a);
    // Twice the signed volume that the ray's line spans with each edge, times the direction's length.
    let u = (c + b).cross(e0).dot(ray.d);
    let v = (a + c).cross(e1).dot(ray.d);
    let w = (b + a).cross(e2).dot(ray.d);
    let smallest = u.min(v).min(w);
    let largest = u.max(v).max(w);
    if !(smallest >= 0.0 || largest <= 0.0) {
        return None;
    }
    let n = e1.cross(e2);
    let det = n.dot(ray.d);
    if det == 0.0 {
        return None;
    }
    let t = n.dot(a) / det;
    if !(t > ray.tmin && t <= ray.tmax) {
        return None;
    }
    let sum = u + v + w;
    if sum == 0.0 {
        return None;
    }
    Some(ShapeHit {
        t,
        u: v / sum,
        v: w / sum,
    })
}
