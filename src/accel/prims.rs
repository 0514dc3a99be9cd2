//! What goes into a tree: numbered boxes.
//!
//! In a scene without instances one tree holds everything that has a box. With instances there are two levels: a tree
//! for each group's triangles, one for the *still* triangles, which are in no group, and above them the top, whose
//! items are shapes, instances and the tree of the still triangles ([`Item`]). What moves is in the top alone.
//!
//! Shapes without bounds are listed apart and tested one by one. A triangle with two equal corners is left out: its
//! edge test is exactly zero for every ray.

use std::ops::Range;

use rayon::prelude::*;

use super::{BuildError, Geometry, Instance, PrimRef, check};
use crate::math::Aabb;

/// Below so many items a task is not worth another thread.
pub(super) const MIN_LEN: usize = 4096;

/// What the number of an item of the top means: primitives come first, then instances, then the still triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Item {
    Prim(PrimRef),
    Instance(Instance),
    Still,
}

impl Item {
    #[inline]
    pub fn new(number: u32, geometry: &Geometry) -> Self {
        let prims = geometry.prim_count() as u32;
        if number < prims {
            Self::Prim(PrimRef::new(number))
        } else if number - prims < geometry.instances.len() as u32 {
            Self::Instance(Instance(number - prims))
        } else {
            Self::Still
        }
    }
}

/// The primitives of a tree.
pub(super) struct Prims {
    /// The primitives' numbers, rising.
    pub ids: Vec<u32>,
    /// Their boxes, in the same order.
    pub boxes: Vec<Aabb>,
    /// What has no box, rising.
    pub unbounded: Vec<PrimRef>,
    /// The largest coordinate of all boxes.
    pub reach: f32,
}

impl Prims {
    /// Everything that is in no group, for one tree over all of it. The geometry is checked.
    pub fn whole(geometry: &Geometry) -> Result<Self, BuildError> {
        let mut prims = Self::triangles(geometry, &geometry.world_triangles());
        prims.add_shapes(geometry)?;
        Ok(prims.measured())
    }

    /// The triangles that are in no group.
    pub fn still(geometry: &Geometry) -> Self {
        Self::triangles(geometry, &geometry.world_triangles()).measured()
    }

    /// A group's triangles.
    pub fn group(geometry: &Geometry, group: usize) -> Self {
        Self::triangles(geometry, std::slice::from_ref(&geometry.groups[group].triangles)).measured()
    }

    /// The items of the top, over a still tree and groups with these boxes.
    pub fn top(geometry: &Geometry, still: &Aabb, groups: &[Aabb]) -> Result<Self, BuildError> {
        let mut prims = Self::triangles(geometry, &[]);
        prims.add_shapes(geometry)?;
        let first = geometry.prim_count() as u32;
        let count = geometry.instances.len();
        let boxes: Vec<Aabb> = (0..count)
            .into_par_iter()
            .with_min_len(MIN_LEN)
            .map(|i| check::instance_bounds(geometry, i, &groups[geometry.instances[i].group as usize]))
            .collect::<Result<_, _>>()?;
        let met = boxes.iter().zip(first..).filter(|(bounds, _)| !bounds.is_empty());
        prims.ids.extend(met.map(|(_, id)| id));
        prims.boxes.extend(boxes.iter().filter(|bounds| !bounds.is_empty()));
        if !still.is_empty() {
            prims.ids.push(first + count as u32);
            prims.boxes.push(*still);
        }
        Ok(prims.measured())
    }

    /// The box around all.
    pub fn bounds(&self) -> Aabb {
        let boxes = self.boxes.par_iter().with_min_len(MIN_LEN).copied();
        boxes.reduce(|| Aabb::EMPTY, Aabb::union)
    }

    fn triangles(geometry: &Geometry, runs: &[Range<u32>]) -> Self {
        let keeps = |i: &u32| {
            let [a, b, c] = geometry.corners(*i as usize);
            a != b && b != c && c != a
        };
        let bounded = |i: u32| geometry.bounds(PrimRef::new(i));
        let (mut ids, mut boxes) = (Vec::new(), Vec::new());
        for run in runs {
            let all = run.clone().into_par_iter().with_min_len(MIN_LEN);
            if all.clone().all(|i| keeps(&i)) {
                ids.extend(run.clone());
                boxes.par_extend(all.map(bounded));
            } else {
                let first = ids.len();
                ids.extend(run.clone().filter(keeps));
                boxes.par_extend(ids[first..].par_iter().with_min_len(MIN_LEN).map(|&i| bounded(i)));
            }
        }
        Self {
            ids,
            boxes,
            unbounded: Vec::new(),
            reach: 0.0,
        }
    }

    fn add_shapes(&mut self, geometry: &Geometry) -> Result<(), BuildError> {
        for id in geometry.triangles.len()..geometry.prim_count() {
            let prim = PrimRef::new(id as u32);
            match check::shape_bounds(geometry, prim)? {
                Some(bounds) => {
                    self.ids.push(id as u32);
                    self.boxes.push(bounds);
                }
                None => self.unbounded.push(prim),
            }
        }
        Ok(())
    }

    fn measured(mut self) -> Self {
        let boxes = self.boxes.par_iter().with_min_len(MIN_LEN);
        let largest = boxes.map(|b| b.min.abs().max(b.max.abs()).max_element());
        self.reach = largest.reduce(|| 0.0, f32::max);
        self
    }
}
