//! What goes into a tree: the primitives that have a box, checked.
//!
//! Numbers that are not finite, or so large that a product of three overflows, are refused here with the primitive's
//! number; a builder that met them would panic or never end. Shapes without bounds are listed apart and tested one by
//! one. A triangle with two equal corners is left out: its edge test is exactly zero for every ray.

use rayon::prelude::*;

use super::{BuildError, Geometry, PrimRef};
use crate::math::Aabb;

/// The largest coordinate that is accepted, in metres: three of them multiplied are still a finite number.
pub const LARGEST: f32 = 1e12;

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
    pub fn new(geometry: &Geometry) -> Result<Self, BuildError> {
        let count = geometry.prim_count();
        if count >= PrimRef::MAX as usize {
            return Err(BuildError::TooMany { count });
        }
        check_triangles(geometry)?;
        let triangles = geometry.triangles.len();
        let shapes = check_shapes(geometry)?;

        let keeps = |i: usize| {
            let [a, b, c] = geometry.corners(i);
            a != b && b != c && c != a
        };
        let dropped = (0..triangles)
            .into_par_iter()
            .with_min_len(MIN_LEN)
            .filter(|&i| !keeps(i))
            .count();
        let bounded = |i: usize| geometry.bounds(PrimRef::new(i as u32));
        let (mut ids, mut boxes): (Vec<u32>, Vec<Aabb>) = if dropped == 0 {
            let boxes = (0..triangles)
                .into_par_iter()
                .with_min_len(MIN_LEN)
                .map(bounded)
                .collect();
            ((0..triangles as u32).collect(), boxes)
        } else {
            let ids: Vec<u32> = (0..triangles as u32).filter(|&i| keeps(i as usize)).collect();
            let boxes = ids
                .par_iter()
                .with_min_len(MIN_LEN)
                .map(|&i| bounded(i as usize))
                .collect();
            (ids, boxes)
        };

        let mut unbounded = Vec::new();
        for (i, bounds) in shapes.into_iter().enumerate() {
            let id = (triangles + i) as u32;
            match bounds {
                Some(bounds) => {
                    ids.push(id);
                    boxes.push(bounds);
                }
                None => unbounded.push(PrimRef::new(id)),
            }
        }
        let reach = boxes
            .par_iter()
            .with_min_len(MIN_LEN)
            .map(|b| b.min.abs().max(b.max.abs()).max_element())
            .reduce(|| 0.0, f32::max);
        Ok(Self {
            ids,
            boxes,
            unbounded,
            reach,
        })
    }
}

/// Below so many items a task is not worth another thread.
const MIN_LEN: usize = 4096;

fn check_triangles(geometry: &Geometry) -> Result<(), BuildError> {
    let vertices = geometry.vertices.len();
    let bad_vertex = |v: &u32| {
        let v = *v as usize;
        v >= vertices || !(geometry.vertices[v].abs().max_element() <= LARGEST && geometry.vertices[v].is_finite())
    };
    let bad = geometry
        .triangles
        .par_iter()
        .with_min_len(MIN_LEN)
        .position_first(|corners| corners.iter().any(bad_vertex));
    let Some(prim) = bad else { return Ok(()) };
    let corners = geometry.triangles[prim];
    Err(match corners.iter().find(|&&v| v as usize >= vertices) {
        Some(&vertex) => BuildError::NoSuchVertex { prim, vertex, vertices },
        None if geometry.corners(prim).iter().all(|p| p.is_finite()) => BuildError::TooLarge { prim },
        None => BuildError::NotFinite { prim },
    })
}

/// The shapes' boxes, `None` for one without bounds.
fn check_shapes(geometry: &Geometry) -> Result<Vec<Option<Aabb>>, BuildError> {
    (geometry.triangles.len()..geometry.prim_count())
        .map(|prim| {
            let id = PrimRef::new(prim as u32);
            let placed = geometry.shape(id).expect("a primitive after the triangles is a shape");
            let local = placed.shape.bounds();
            if local.min.is_nan() || local.max.is_nan() {
                return Err(BuildError::NotFinite { prim });
            }
            if !local.is_finite() {
                return Ok(None);
            }
            let bounds = geometry.bounds(id);
            if !bounds.is_finite() {
                return Err(BuildError::NotFinite { prim });
            }
            if bounds.min.abs().max(bounds.max.abs()).max_element() > LARGEST {
                return Err(BuildError::TooLarge { prim });
            }
            Ok(Some(bounds))
        })
        .collect()
}
