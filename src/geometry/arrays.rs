//! The geometry of a scene: flat arrays of triangles and world-space shapes, and instanced meshes.

use std::ops::Range;

use super::{
    ids::{Hit, InstanceId, PrimId},
    padding,
    slab::Slabs,
};
use crate::{
    math::{Aabb, Ray, Transform, Vec3},
    shape::{FlatPlace, Numbers, Shape, ShapeHit, triangle},
};

/// The padding of boxes around their contents, in units in the last place.
const PADDING: f32 = 4.0;

/// A shape with its transform to world space.
#[derive(Clone, Copy, Debug)]
pub struct PlacedShape {
    pub shape: Shape,
    /// An index into [`Geometry::transforms`]; `None` if local space is world space.
    pub transform: Option<u32>,
    /// [`Shape::block_numbers`].
    pub(super) numbers: Numbers,
    /// The padded world-space bounds. They are cached, since every hit is clipped to them.
    bounds: Aabb,
    is_bounded: bool,
}

/// Triangles in a local space of their own. They are stored once and hit wherever an instance
/// places them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshGroup {
    /// The range of the geometry's triangles. Groups have no triangle in common and are sorted by
    /// their triangles.
    pub triangles: Range<u32>,
    /// The range of the geometry's vertices that these triangles use; no other triangle uses them.
    pub vertices: Range<u32>,
}

/// An instance of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GroupInstance {
    /// An index into [`Geometry::groups`].
    pub group: u32,
    /// An index into [`Geometry::transforms`]. An instance that moves has a transform of its own.
    pub transform: u32,
}

/// All primitives of a scene. Primitive `i` is triangle `i`, or shape `i - triangles.len()`.
///
/// The triangles of a group are hit in the group's instances only. Such a hit has the id of the
/// triangle and that of the instance, which is an index into `instances`.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    /// In world space; the vertices of a group in the group's local space.
    pub vertices: Vec<Vec3>,
    /// Three indices into `vertices` each.
    pub triangles: Vec<[u32; 3]>,
    pub shapes: Vec<PlacedShape>,
    pub transforms: Vec<Transform>,
    pub groups: Vec<MeshGroup>,
    pub instances: Vec<GroupInstance>,
}

impl PlacedShape {
    /// Returns the bounds to which hits are clipped, infinite where the shape has none.
    #[inline(always)]
    pub(super) fn clip_bounds(&self) -> &Aabb {
        if self.is_bounded {
            &self.bounds
        } else {
            &Aabb::UNBOUNDED
        }
    }
}

impl Geometry {
    /// Returns the number of stored primitives; those of groups count once.
    pub fn prim_count(&self) -> usize {
        self.triangles.len() + self.shapes.len()
    }

    /// Returns the number of primitives that a ray can hit; those of groups count once per
    /// instance.
    pub fn instanced_prim_count(&self) -> u64 {
        let of = |group: &MeshGroup| group.triangles.len() as u64;
        let stored: u64 = self.groups.iter().map(of).sum();
        let seen: u64 = self.instances.iter().map(|i| of(&self.groups[i.group as usize])).sum();
        self.prim_count() as u64 - stored + seen
    }

    /// Returns the triangles that are in no group.
    pub fn world_triangles(&self) -> Vec<Range<u32>> {
        let starts = std::iter::once(0).chain(self.groups.iter().map(|g| g.triangles.end));
        let ends = self.groups.iter().map(|g| g.triangles.start);
        let ends = ends.chain([self.triangles.len() as u32]);
        starts.zip(ends).map(|(a, b)| a..b).filter(|r| !r.is_empty()).collect()
    }

    /// Adds a shape with its transform to world space, and returns its index among the shapes.
    pub fn add_shape(&mut self, shape: Shape, transform: Option<Transform>) -> u32 {
        let bounds = placed_bounds(&shape, None);
        self.shapes.push(PlacedShape {
            shape,
            transform: None,
            numbers: shape.block_numbers(),
            bounds,
            is_bounded: bounds.is_finite(),
        });
        let index = self.shapes.len() as u32 - 1;
        if let Some(transform) = transform {
            self.place_shape(index, transform);
        }
        index
    }

    /// Sets a shape's transform to world space.
    pub fn place_shape(&mut self, index: u32, transform: Transform) {
        let placed = &mut self.shapes[index as usize];
        placed.bounds = placed_bounds(&placed.shape, Some(&transform));
        placed.is_bounded = placed.bounds.is_finite();
        match placed.transform {
            Some(at) => self.transforms[at as usize] = transform,
            None => {
                placed.transform = Some(self.transforms.len() as u32);
                self.transforms.push(transform);
            }
        }
    }

    /// Returns the vertices of triangle `i`.
    #[inline(always)]
    pub fn corners(&self, i: usize) -> [Vec3; 3] {
        // One by one, so that the vertices stay in registers.
        let [a, b, c] = self.triangles[i];
        let at = |v: u32| self.vertices[v as usize];
        [at(a), at(b), at(c)]
    }

    /// Returns the triangles in the space of `prim` that rays are tested with, and the key of each: itself if it is a triangle,
    /// those of a parallelogram, and none of another shape or item of a tree.
    pub(crate) fn triangles_of(&self, prim: PrimId) -> impl Iterator<Item = (u32, [Vec3; 3])> + use<> {
        let index = prim.index() as usize;
        let triangles = match index.checked_sub(self.triangles.len()) {
            None => [Some(self.corners(index)), None],
            Some(shape) => {
                let halves = self.shapes.get(shape).and_then(|placed| self.halves(placed));
                halves.map_or([None; 2], |halves| halves.map(Some))
            }
        };
        (0..)
            .zip(triangles)
            .filter_map(move |(i, corners)| Some((prim.key(i), corners?)))
    }

    /// Returns the triangles of a parallelogram in world space.
    #[inline]
    pub(crate) fn halves(&self, placed: &PlacedShape) -> Option<[[Vec3; 3]; 2]> {
        halves(&placed.shape, self.transform(placed))
    }

    /// Returns the place in world space on a parallelogram where `ray` meets it at `t`; `None` for other shapes.
    #[inline]
    pub(crate) fn place_on_parallelogram(&self, placed: &PlacedShape, ray: &Ray, t: f32) -> Option<FlatPlace> {
        let own = placed.shape.parallelogram()?;
        let p = ray.at(t);
        Some(match self.transform(placed) {
            None => own.place(p),
            Some(transform) => own.place_in_world(transform, p),
        })
    }

    /// Returns the shape with the id `prim`, or `None` for a triangle.
    #[inline]
    pub fn shape(&self, prim: PrimId) -> Option<&PlacedShape> {
        let i = prim.index() as usize;
        i.checked_sub(self.triangles.len()).map(|i| &self.shapes[i])
    }

    /// Returns the transform of a shape.
    #[inline]
    pub fn transform(&self, placed: &PlacedShape) -> Option<&Transform> {
        placed.transform.map(|t| &self.transforms[t as usize])
    }

    /// Returns the transforms of all instances.
    pub fn instance_transforms(&self) -> impl Iterator<Item = &Transform> {
        self.instances
            .iter()
            .map(|placed| &self.transforms[placed.transform as usize])
    }

    /// Returns the transform of an instance; `None` for [`InstanceId::NONE`].
    #[inline]
    pub fn place(&self, instance: InstanceId) -> Option<&Transform> {
        let placed = self.instances.get(instance.0 as usize)?;
        Some(&self.transforms[placed.transform as usize])
    }

    /// Transforms a ray to the local space of an instance. The direction is not normalised, so `t`
    /// is the same in both spaces.
    #[inline(always)]
    pub fn enter(&self, placed: &GroupInstance, ray: &Ray) -> Ray {
        self.transforms[placed.transform as usize].ray_to_local(ray)
    }

    /// Returns the bounds of `prim` in its space, padded so that rounding in a box test never loses
    /// a hit.
    pub fn bounds(&self, prim: PrimId) -> Aabb {
        match self.shape(prim) {
            None => triangle_bounds(self.corners(prim.index() as usize)),
            Some(placed) => placed.bounds,
        }
    }

    /// Returns the bounds of a group's triangles, in local space.
    pub fn group_bounds(&self, group: &MeshGroup) -> Aabb {
        let prims = group.triangles.clone().map(PrimId::new);
        prims.map(|prim| self.bounds(prim)).fold(Aabb::EMPTY, Aabb::union)
    }

    /// Returns the world-space bounds of everything that has bounds.
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

    /// Returns the same geometry without instances: every instanced triangle becomes a world-space
    /// triangle.
    ///
    /// The ids of primitives change: primitives that are in no group come first, then those of each
    /// instance in order.
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

    /// Intersects `ray`, in the space of `prim`, with `prim`, for `tmin < t <= tmax`.
    ///
    /// The primitive is first intersected with the whole line, and `t` is clipped to the
    /// primitive's bounds before it is compared with the ray's extent. So the hit does not depend
    /// on how much of the ray was left.
    #[inline]
    pub fn intersect(&self, prim: PrimId, ray: &Ray) -> Option<ShapeHit> {
        let Some(placed) = self.shape(prim) else {
            return intersect_triangle(ray, self.corners(prim.index() as usize));
        };
        self.intersect_shape(placed, ray, || Slabs::new(ray))
    }

    /// Intersects a ray with a shape; `slabs` are those of the ray.
    #[inline]
    pub(crate) fn intersect_shape(
        &self,
        placed: &PlacedShape,
        ray: &Ray,
        slabs: impl FnOnce() -> Slabs,
    ) -> Option<ShapeHit> {
        if let Some(halves) = self.halves(placed) {
            let [first, second] = halves.map(|corners| intersect_triangle(ray, corners));
            return match (first, second) {
                (Some(a), Some(b)) => Some(if b.t < a.t { b } else { a }),
                (a, b) => a.or(b),
            };
        }
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

    /// Intersects `prim` of `instance` with a ray in its space. A hit is stored in `best`, and
    /// `ray.tmax` reduced, if it [comes before](Hit::comes_before) the one that is there.
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

    /// Calls [`Geometry::keep_nearest`] for each of these world-space primitives.
    pub fn keep_nearest_of(&self, prims: &[PrimId], ray: &mut Ray, best: &mut Option<Hit>) {
        for &prim in prims {
            self.keep_nearest(prim, InstanceId::NONE, ray, best);
        }
    }
}

/// Intersects a ray with a triangle, as [`Geometry::intersect`] does.
#[inline]
fn intersect_triangle(ray: &Ray, corners: [Vec3; 3]) -> Option<ShapeHit> {
    let [a, b, c] = corners;
    let line = Ray {
        tmin: f32::NEG_INFINITY,
        tmax: f32::INFINITY,
        ..*ray
    };
    let hit = triangle::intersect(&line, a, b, c).filter(|h| !(h.u.is_nan() || h.v.is_nan()))?;
    let t = Slabs::new(ray).clip_triangle(hit.t, &triangle_bounds(corners))?;
    (t > ray.tmin && t <= ray.tmax).then_some(ShapeHit { t, ..hit })
}

fn triangle_bounds(corners: [Vec3; 3]) -> Aabb {
    Aabb::from_points(corners).padded(PADDING)
}

/// Returns the triangles of a parallelogram in world space.
#[inline]
fn halves(shape: &Shape, transform: Option<&Transform>) -> Option<[[Vec3; 3]; 2]> {
    let own = shape.parallelogram()?.halves();
    Some(transform.map_or(own, |t| own.map(|corners| corners.map(|p| t.point_to_world(p)))))
}

/// Returns the padded bounds of a shape in world space.
fn placed_bounds(shape: &Shape, transform: Option<&Transform>) -> Aabb {
    match (halves(shape, transform), transform) {
        (Some(halves), _) => halves.map(triangle_bounds).into_iter().fold(Aabb::EMPTY, Aabb::union),
        (None, None) => shape.bounds().padded(PADDING),
        (None, Some(t)) => t.bounds_to_world(&shape.bounds()).padded(PADDING),
    }
}
