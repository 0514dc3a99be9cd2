//! The kernels of the wide tree.
//!
//! Each kernel is written once, generic over [`SimdLevel`], and compiled for every level of
//! [`Isa`]. All levels return the same bits: culling is conservative by more than the rounding of
//! any level ([`crate::geometry::slab`]), and hits are computed by the same operations in the same
//! order, without fused multiply-add.
//!
//! This module contains all `unsafe` code of the accelerators. It indexes without bounds checks
//! what [`tree::WideTree`] has validated.
//!
//! [`SimdLevel`]: crate::simd::lanes::SimdLevel
//! [`Isa`]: crate::simd::Isa

mod aliased_buffer;
mod analytic;
mod hits;
mod leaf_queue;
pub(super) mod packet;
mod query;
pub(super) mod ray16;
mod ray_rows;
pub(super) mod ray_selection;
mod ray_state;
pub(super) mod ray_stream;
mod refit;
pub(super) mod scratch;
mod slot_set;
mod stack;
mod traversal;
mod traversal_state;
pub(super) mod tree;
mod triangle;

use packet::PacketBatch;
use query::{Nearest, Occluded};
use ray_selection::RaySelection;
use scratch::Scratch;
use tree::WideTree;

use crate::{
    geometry::{Geometry, Hit},
    math::Ray,
    simd::dispatch::kernel,
};

kernel! {
    /// Finds the nearest hits of the selected rays, if they are nearer than those in `hits`.
    nearest_stream(
        tree: &WideTree,
        geometry: &Geometry,
        rays: &[Ray],
        selection: RaySelection,
        hits: &mut [Option<Hit>],
        scratch: &mut Scratch,
    ) = |level| if tree.has_instances() {
        ray_stream::trace::<_, Nearest, true>(level, tree, geometry, rays, selection, hits, scratch);
    } else {
        ray_stream::trace::<_, Nearest, false>(level, tree, geometry, rays, selection, hits, scratch);
    }
}

kernel! {
    /// Finds out whether rays are occluded. Rays that are already marked in `blocked` are skipped.
    occluded_stream(
        tree: &WideTree,
        geometry: &Geometry,
        rays: &[Ray],
        blocked: &mut [bool],
        scratch: &mut Scratch,
    ) = |level| if tree.has_instances() {
        ray_stream::trace::<_, Occluded, true>(level, tree, geometry, rays, RaySelection::All, blocked, scratch);
    } else {
        ray_stream::trace::<_, Occluded, false>(level, tree, geometry, rays, RaySelection::All, blocked, scratch);
    }
}

kernel! {
    /// Finds the nearest hits of rays in packets of [`RAYS`], if they are nearer than those in
    /// `hits`. The indices of rays that still have to be traced one by one are written to
    /// `remaining`.
    ///
    /// [`RAYS`]: ray16::RAYS
    nearest_packets(
        tree: &WideTree,
        geometry: &Geometry,
        batch: PacketBatch<'_>,
        hits: &mut [Option<Hit>],
        remaining: &mut Vec<u32>,
        scratch: &mut Scratch,
    ) = |level| {
        packet::trace(level, tree, geometry, batch, hits, remaining, scratch);
    }
}
