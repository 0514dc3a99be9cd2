//! What is traced: flat arrays of triangles and of shapes, in world space.

use super::{Hit, Instance, PrimRef, slab::Slabs};
use crate::{
    math::{Aabb, Ray, Transform, Vec3},
    shape::{Shape, ShapeHit, triangle},
};

/// A shape at its place in the world.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    pub shape: Shape,
    /// An index into [`Geometry::transforms`]; `None` where local space is the world.
    pub transform: Option<u32>,
}

/// All primitives of a scene. Primitive `i` is triangle `i`, or shape `i - triangles.len()`.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    /// In world space.
    pub vertices: Vec<Vec3>,
    /// Three indices into `vertices` each.
    pub triangles: Vec<[u32; 3]>,
    pub shapes: Vec<Placed>,
    pub transforms: Vec<Transform>,
}

impl Geometry {
    pub fn prim_count(&self) -> usize {
        self.triangles.len() + self.shapes.len()
    }

    /// The corners of triangle `i`.
    #[inline]
    pub fn corners(&self, i: usize) -> [Vec3; 3] {
        self.triangles[i].map(|v| self.vertices[v as usize])
    }

    /// The shape that `prim` is, `None` for a triangle.
    #[inline]
    pub fn shape(&self, prim: PrimRef) -> Option<&Placed> {
        let i = prim.index() as usize;
        i.checked_sub(self.triangles.len()).map(|i| &self.shapes[i])
    }

    /// The transform of a placed shape.
    #[inline]
    pub fn transform(&self, placed: &Placed) -> Option<&Transform> {
        placed.transform.map(|t| &self.transforms[t as usize])
    }

    /// A box around `prim` in world space, a little larger than it, so that rounding in a box test never loses a hit.
    pub fn bounds(&self, prim: PrimRef) -> Aabb {
        let bounds = match self.shape(prim) {
            None => Aabb::from_points(self.corners(prim.index() as usize)),
            Some(placed) => {
                let local = placed.shape.bounds();
                self.transform(placed).map_or(local, |t| t.bounds_to_world(&local))
            }
        };
        bounds.padded(4.0)
    }

    /// Where `ray` meets `prim` with `tmin < t <= tmax`.
    ///
    /// Each primitive is asked about the whole of the line first, and `t` is brought into the primitive's own box
    /// before it is compared with the ray's bounds, so that the answer does not depend on how much of the ray was left.
    #[inline]
    pub fn intersect(&self, prim: PrimRef, ray: &Ray) -> Option<ShapeHit> {
        let hit = match self.shape(prim) {
            None => {
                let [a, b, c] = self.corners(prim.index() as usize);
                let line = Ray {
                    tmin: f32::NEG_INFINITY,
                    tmax: f32::INFINITY,
                    ..*ray
                };
                triangle::intersect(&line, a, b, c).filter(|h| !(h.u.is_nan() || h.v.is_nan()))?
            }
            Some(placed) => {
                let line = Ray {
                    tmax: f32::INFINITY,
                    ..*ray
                };
                match self.transform(placed) {
                    None => placed.shape.intersect(&line)?,
                    Some(t) => placed.shape.intersect(&t.ray_to_local(&line))?,
                }
            }
        };
        let own = self.bounds(prim);
        let t = if self.shape(prim).is_none() {
            Slabs::new(ray).clip_triangle(hit.t, &own)?
        } else if own.is_finite() {
            Slabs::new(ray).clip(hit.t, &own)?
        } else {
            hit.t
        };
        (t > ray.tmin && t <= ray.tmax).then_some(ShapeHit { t, ..hit })
    }

    /// Tests `prim` and keeps it in `best` where it is nearer, or as near with a lower number; `ray.tmax` shrinks with it.
    #[inline]
    pub fn keep_nearest(&self, prim: PrimRef, ray: &mut Ray, best: &mut Option<Hit>) {
        if let Some(ShapeHit { t, u, v }) = self.intersect(prim, ray) {
            let wins = best.is_none_or(|b| t < b.t || (t == b.t && prim < b.prim));
            if wins {
                ray.tmax = t;
                *best = Some(Hit {
                    t,
                    u,
                    v,
                    prim,
                    instance: Instance::NONE,
                });
            }
        }
    }
}
