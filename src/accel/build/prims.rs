//! The input of a build: numbered boxes.
//!
//! In a scene without instances, one tree holds everything that has bounds. With instances there
//! are two levels: one tree per group and one for the *static* triangles, which are in no group;
//! and above them the top-level tree, whose items are shapes, instances and the tree of the static
//! triangles ([`Item`]). Only the top-level tree holds what moves.
//!
//! Unbounded shapes are listed separately and tested one by one. A triangle with two equal vertices
//! is left out: its edge function is exactly zero for every ray.

use std::ops::Range;

use rayon::prelude::*;

use super::median_split::{PrimBox, SetBounds};
use crate::{
    geometry::{BuildError, Geometry, InstanceId, PrimId, check, check::PAR_MIN_LEN},
    math::Aabb,
};

/// An item of the top-level tree. Numbers are assigned to primitives first, then to instances, then
/// to the static triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    Prim(PrimId),
    InstanceId(InstanceId),
    StaticTree,
}

impl Item {
    #[inline]
    pub fn new(number: u32, geometry: &Geometry) -> Self {
        let prims = geometry.prim_count() as u32;
        if number < prims {
            Self::Prim(PrimId::new(number))
        } else if number - prims < geometry.instances.len() as u32 {
            Self::InstanceId(InstanceId(number - prims))
        } else {
            Self::StaticTree
        }
    }
}

/// The future use of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mobility {
    /// The tree is never refitted.
    Fixed,
    /// The tree may be refitted to moved triangles.
    Moving,
}

/// The primitives of a tree.
pub struct Prims {
    /// The primitives' boxes with their ids, in ascending order.
    pub refs: Vec<PrimBox>,
    /// The bounds of all boxes.
    pub around: SetBounds,
    pub mobility: Mobility,
    /// The unbounded primitives, in ascending order.
    pub unbounded: Vec<PrimId>,
    /// The largest coordinate of all boxes.
    pub reach: f32,
}

impl Prims {
    /// Returns everything that is in no group, for a single tree. The geometry must be valid.
    pub fn whole(geometry: &Geometry) -> Result<Self, BuildError> {
        let mut prims = Self::triangles(geometry, &geometry.world_triangles());
        prims.mobility = Mobility::Fixed;
        prims.add_shapes(geometry)?;
        Ok(prims.measured())
    }

    /// Returns the triangles that are in no group.
    pub fn static_triangles(geometry: &Geometry) -> Self {
        Self::triangles(geometry, &geometry.world_triangles()).measured()
    }

    /// Returns the triangles of a group.
    pub fn group(geometry: &Geometry, group: usize) -> Self {
        Self::triangles(geometry, std::slice::from_ref(&geometry.groups[group].triangles)).measured()
    }

    /// Returns the items of the top-level tree, given the bounds of the static tree and of the
    /// groups.
    pub fn top(geometry: &Geometry, static_bounds: &Aabb, groups: &[Aabb]) -> Result<Self, BuildError> {
        let mut prims = Self::triangles(geometry, &[]);
        prims.add_shapes(geometry)?;
        let first = geometry.prim_count() as u32;
        let count = geometry.instances.len();
        let boxes: Vec<Aabb> = (0..count)
            .into_par_iter()
            .with_min_len(PAR_MIN_LEN)
            .map(|i| check::instance_bounds(geometry, i, &groups[geometry.instances[i].group as usize]))
            .collect::<Result<_, _>>()?;
        let met = boxes.iter().zip(first..).filter(|(bounds, _)| !bounds.is_empty());
        prims.refs.extend(met.map(|(bounds, id)| PrimBox::new(bounds, id)));
        if !static_bounds.is_empty() {
            prims.refs.push(PrimBox::new(static_bounds, first + count as u32));
        }
        Ok(prims.measured())
    }

    /// Returns the bounds of all boxes.
    pub fn bounds(&self) -> Aabb {
        self.around.boxes.aabb()
    }

    fn triangles(geometry: &Geometry, runs: &[Range<u32>]) -> Self {
        let keeps = |i: &u32| {
            let [a, b, c] = geometry.corners(*i as usize);
            a != b && b != c && c != a
        };
        let boxed = |i: u32| PrimBox::new(&geometry.bounds(PrimId::new(i)), i);
        let mut refs = Vec::new();
        for run in runs {
            let all = run.clone().into_par_iter().with_min_len(PAR_MIN_LEN);
            if all.clone().all(|i| keeps(&i)) {
                refs.par_extend(all.map(boxed));
            } else {
                refs.par_extend(all.filter(keeps).map(boxed));
            }
        }
        Self {
            refs,
            around: SetBounds::EMPTY,
            mobility: Mobility::Moving,
            unbounded: Vec::new(),
            reach: 0.0,
        }
    }

    fn add_shapes(&mut self, geometry: &Geometry) -> Result<(), BuildError> {
        for id in geometry.triangles.len()..geometry.prim_count() {
            let prim = PrimId::new(id as u32);
            match check::shape_bounds(geometry, prim)? {
                Some(bounds) => self.refs.push(PrimBox::new(&bounds, id as u32)),
                None => self.unbounded.push(prim),
            }
        }
        Ok(())
    }

    fn measured(mut self) -> Self {
        self.around = SetBounds::of(&self.refs);
        let bounds = self.bounds();
        if !bounds.is_empty() {
            self.reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        }
        self
    }
}
