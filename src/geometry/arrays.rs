//! What is traced: flat arrays of triangles and of shapes in world space, and meshes that stand in it many times.

use std::ops::Range;

use super::{
    ids::{Hit, InstanceId, PrimId},
    padding,
    slab::Slabs,
};
use crate::{
    math::{Aabb, Dispatch, Ray, Transform, Vec3, VectorLoop},
    shape::{Attempt, Shape, ShapeHit, triangle},
};

/// By how many units in the last place boxes are larger than what is in them.
const PADDING: f32 = 4.0;

/// A shape at its place in the world.
#[derive(Clone, Copy, Debug)]
pub struct PlacedShape {
    pub shape: Shape,
    /// An index into [`Geometry::transforms`]; `None` where local space is the world.
    pub transform: Option<u32>,
    /// Its box in the world, a little larger than it; kept, since every hit is brought into it.
    bounds: Aabb,
    is_bounded: bool,
}

/// Triangles in a space of their own: they are stored once, and met wherever an instance puts them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshGroup {
    /// Which of the geometry's triangles. Groups have no triangle in common and are in the order of their triangles.
    pub triangles: Range<u32>,
    /// Which of the geometry's vertices their corners are; nothing else names these.
    pub vertices: Range<u32>,
}

/// A group at a place in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GroupInstance {
    /// An index into [`Geometry::groups`].
    pub group: u32,
    /// An index into [`Geometry::transforms`], which no other instance names where it is to be moved.
    pub transform: u32,
}

/// All primitives of a scene. Primitive `i` is triangle `i`, or shape `i - triangles.len()`.
///
/// What is in a group is not met by itself, but in each of the group's instances: a hit there has the triangle's number
/// and the instance's, which is an index into `instances`.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    /// In world space; those of a group in the group's own.
    pub vertices: Vec<Vec3>,
    /// Three indices into `vertices` each.
    pub triangles: Vec<[u32; 3]>,
    pub shapes: Vec<PlacedShape>,
    pub transforms: Vec<Transform>,
    pub groups: Vec<MeshGroup>,
    pub instances: Vec<GroupInstance>,
}

/// Brings attempts into a shape's own box.
struct Clips<'a> {
    slabs: &'a [Slabs],
    own: Aabb,
    attempts: &'a mut [Attempt],
}

impl VectorLoop for Clips<'_> {
    #[inline(always)]
    fn run(self) {
        for (slabs, attempt) in self.slabs.iter().zip(self.attempts) {
            let (t, meets) = slabs.bring(attempt.hit.t, &self.own);
            attempt.hit.t = t;
            attempt.answer = if meets { attempt.answer } else { Attempt::MISSES };
        }
    }
}

impl Geometry {
    /// How many primitives are stored, those of groups once.
    pub fn prim_count(&self) -> usize {
        self.triangles.len() + self.shapes.len()
    }

    /// How many primitives a ray can meet, those of groups once for each instance.
    pub fn instanced_prim_count(&self) -> u64 {
        let of = |group: &MeshGroup| group.triangles.len() as u64;
        let stored: u64 = self.groups.iter().map(of).sum();
        let seen: u64 = self.instances.iter().map(|i| of(&self.groups[i.group as usize])).sum();
        self.prim_count() as u64 - stored + seen
    }

    /// The triangles that are in no group.
    pub fn world_triangles(&self) -> Vec<Range<u32>> {
        let starts = std::iter::once(0).chain(self.groups.iter().map(|g| g.triangles.end));
        let ends = self.groups.iter().map(|g| g.triangles.start);
        let ends = ends.chain([self.triangles.len() as u32]);
        starts.zip(ends).map(|(a, b)| a..b).filter(|r| !r.is_empty()).collect()
    }

    /// Adds a shape, whose number among shapes is returned; `transform` takes it to its place.
    pub fn add_shape(&mut self, shape: Shape, transform: Option<Transform>) -> u32 {
        let bounds = shape.bounds().padded(PADDING);
        self.shapes.push(PlacedShape {
            shape,
            transform: None,
            bounds,
            is_bounded: bounds.is_finite(),
        });
        let index = self.shapes.len() as u32 - 1;
        if let Some(transform) = transform {
            self.place_shape(index, transform);
        }
        index
    }

    /// Takes a shape to another place.
    pub fn place_shape(&mut self, index: u32, transform: Transform) {
        let placed = &mut self.shapes[index as usize];
        placed.bounds = transform.bounds_to_world(&placed.shape.bounds()).padded(PADDING);
        placed.is_bounded = placed.bounds.is_finite();
        match placed.transform {
            Some(at) => self.transforms[at as usize] = transform,
            None => {
                placed.transform = Some(self.transforms.len() as u32);
                self.transforms.push(transform);
            }
        }
    }

    /// The corners of triangle `i`.
    #[inline(always)]
    pub fn corners(&self, i: usize) -> [Vec3; 3] {
        // One by one, so that they stay in registers.
        let [a, b, c] = self.triangles[i];
        let at = |v: u32| self.vertices[v as usize];
        [at(a), at(b), at(c)]
    }

    /// The shape that `prim` is, `None` for a triangle.
    #[inline]
    pub fn shape(&self, prim: PrimId) -> Option<&PlacedShape> {
        let i = prim.index() as usize;
        i.checked_sub(self.triangles.len()).map(|i| &self.shapes[i])
    }

    /// The transform of a placed shape.
    #[inline]
    pub fn transform(&self, placed: &PlacedShape) -> Option<&Transform> {
        placed.transform.map(|t| &self.transforms[t as usize])
    }

    /// Where the instances stand.
    pub fn instance_transforms(&self) -> impl Iterator<Item = &Transform> {
        self.instances
            .iter()
            .map(|placed| &self.transforms[placed.transform as usize])
    }

    /// Where an instance stands; `None` for [`InstanceId::NONE`].
    #[inline]
    pub fn place(&self, instance: InstanceId) -> Option<&Transform> {
        let placed = self.instances.get(instance.0 as usize)?;
        Some(&self.transforms[placed.transform as usize])
    }

    /// A ray in the space of an instance's group. It is not normalised, so `t` is the same in both spaces.
    #[inline(always)]
    pub fn enter(&self, placed: &GroupInstance, ray: &Ray) -> Ray {
        self.transforms[placed.transform as usize].ray_to_local(ray)
    }

    /// A box around `prim` in its space, a little larger than it, so that rounding in a box test never loses a hit.
    pub fn bounds(&self, prim: PrimId) -> Aabb {
        match self.shape(prim) {
            None => Aabb::from_points(self.corners(prim.index() as usize)).padded(PADDING),
            Some(placed) => placed.bounds,
        }
    }

    /// The box around all of a group's triangles, in its own space.
    pub fn group_bounds(&self, group: &MeshGroup) -> Aabb {
        let prims = group.triangles.clone().map(PrimId::new);
        prims.map(|prim| self.bounds(prim)).fold(Aabb::EMPTY, Aabb::union)
    }

    /// The box around everything that has bounds, in world space.
    pub fn world_bounds(&self) -> Aabb {
        let shapes = self.triangles.len() as u32..self.prim_count() as u32;
        let prims = self.world_triangles().into_iter().chain([shapes]).flatten();
        let prims = prims.map(|i| self.bounds(PrimId::new(i))).filter(Aabb::is_finite);
        let groups: Vec<Aabb> = self.groups.iter().map(|g| self.group_bounds(g)).collect();
        let instances = self.instances.iter().map(|placed| {
            let t = &self.transforms[placed.transform as usize];
            padding::bounds(t, &groups[placed.group as usize])
        });
        prims.chain(instances).fold(Aabb::EMPTY, Aabb::union)
    }

    /// The same with a triangle of its own for every triangle that can be seen, all in world space.
    ///
    /// Numbers of primitives change: what was in no group comes first, then each instance in turn.
    pub fn without_instances(&self) -> Self {
        let mut flat = Self {
            vertices: self.vertices.clone(),
            shapes: self.shapes.clone(),
            transforms: self.transforms.clone(),
            ..Self::default()
        };
        let world = self.world_triangles().into_iter().flatten();
        flat.triangles.extend(world.map(|i| self.triangles[i as usize]));
        for placed in &self.instances {
            let group = &self.groups[placed.group as usize];
            let place = &self.transforms[placed.transform as usize];
            let moved = flat.vertices.len() as u32;
            for v in group.vertices.clone() {
                flat.vertices.push(place.point_to_world(self.vertices[v as usize]));
            }
            for i in group.triangles.clone() {
                let corners = self.triangles[i as usize].map(|v| v - group.vertices.start + moved);
                let [a, b, c] = corners;
                flat.triangles
                    .push(if place.is_mirroring() { [a, c, b] } else { corners });
            }
        }
        flat
    }

    /// Where `ray`, in the space of `prim`, meets it with `tmin < t <= tmax`.
    ///
    /// Each primitive is asked about the whole of the line first, and `t` is brought into the primitive's own box
    /// before it is compared with the ray's bounds, so that the answer does not depend on how much of the ray was left.
    #[inline]
    pub fn intersect(&self, prim: PrimId, ray: &Ray) -> Option<ShapeHit> {
        let Some(placed) = self.shape(prim) else {
            let [a, b, c] = self.corners(prim.index() as usize);
            let line = Ray {
                tmin: f32::NEG_INFINITY,
                tmax: f32::INFINITY,
                ..*ray
            };
            let hit = triangle::intersect(&line, a, b, c).filter(|h| !(h.u.is_nan() || h.v.is_nan()))?;
            let t = Slabs::new(ray).clip_triangle(hit.t, &self.bounds(prim))?;
            return (t > ray.tmin && t <= ray.tmax).then_some(ShapeHit { t, ..hit });
        };
        self.intersect_shape(placed, ray, || Slabs::new(ray))
    }

    /// The same for a shape; `slabs` are the ray's.
    #[inline]
    pub(crate) fn intersect_shape(
        &self,
        placed: &PlacedShape,
        ray: &Ray,
        slabs: impl FnOnce() -> Slabs,
    ) -> Option<ShapeHit> {
        let line = Ray {
            tmax: f32::INFINITY,
            ..*ray
        };
        let hit = match self.transform(placed) {
            None => placed.shape.intersect(&line)?,
            Some(t) => placed.shape.intersect(&t.ray_to_local(&line))?,
        };
        let t = if placed.is_bounded {
            slabs().clip(hit.t, &placed.bounds)?
        } else {
            hit.t
        };
        (t > ray.tmin && t <= ray.tmax).then_some(ShapeHit { t, ..hit })
    }

    /// What can be told of [`Geometry::intersect_shape`] for many rays at once; `slabs` are the rays'.
    #[inline(always)]
    pub(crate) fn attempt_shape(
        &self,
        on: impl Dispatch,
        placed: &PlacedShape,
        rays: &mut [Ray],
        slabs: &[Slabs],
        attempts: &mut [Attempt],
    ) {
        if let Some(t) = self.transform(placed) {
            for ray in &mut *rays {
                *ray = t.ray_to_local(ray);
            }
        }
        placed.shape.attempt(on, rays, attempts);
        if placed.is_bounded {
            on.dispatch(Clips {
                slabs,
                own: placed.bounds,
                attempts,
            });
        }
    }

    /// Tests `prim` of `instance` with a ray in its space and keeps it in `best` where it is nearer, or as near and
    /// [`Hit::comes_before`]; `ray.tmax` shrinks with it.
    #[inline]
    pub fn keep_nearest(&self, prim: PrimId, instance: InstanceId, ray: &mut Ray, best: &mut Option<Hit>) {
        if let Some(ShapeHit { t, u, v }) = self.intersect(prim, ray) {
            let hit = Hit {
                t,
                u,
                v,
                prim,
                instance,
            };
            if best.is_none_or(|b| hit.comes_before(&b)) {
                ray.tmax = t;
                *best = Some(hit);
            }
        }
    }

    /// Does so with each of some primitives in world space.
    pub fn keep_nearest_of(&self, prims: &[PrimId], ray: &mut Ray, best: &mut Option<Hit>) {
        for &prim in prims {
            self.keep_nearest(prim, InstanceId::NONE, ray, best);
        }
    }
}
