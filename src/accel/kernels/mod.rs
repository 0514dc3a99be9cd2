//! The kernels of the wide tree, for every processor.
//!
//! Each is written once, over [`SimdLevel`], and compiled for every level that [`Isa`] knows. All give the same bits: culling is
//! widened by more than any level rounds ([`crate::geometry::slab`]), and what decides about hits is the same operations in
//! the same order, none of them fused.
//!
//! All `unsafe` code of the accelerators is in here. It indexes without checks what [`tree::WideTree`] has checked.
//!
//! [`SimdLevel`]: crate::simd::lanes::Level
//! [`Isa`]: crate::simd::Simd

mod aliased_buffer;
mod analytic;
mod entry_points;
mod hits;
mod leaf_queue;
mod occluder_cache;
pub(super) mod packet;
mod query;
pub(super) mod ray16;
mod ray_rows;
pub(super) mod ray_selection;
mod ray_state;
pub(super) mod ray_stream;
mod refit;
pub(super) mod scratch;
mod shaft;
mod slot_set;
mod stack;
mod traversal;
mod traversal_state;
pub(super) mod tree;
mod triangle;

use packet::{PacketBatch, order::PacketOrder};
use query::{Nearest, Occluded};
use ray_selection::RaySelection;
use ray_stream::StreamReport;
use scratch::Scratch;
use tree::WideTree;

use crate::{
    geometry::{Geometry, Hit},
    math::Ray,
    simd::dispatch::kernel,
};

kernel! {
    /// The nearest hits of the picked rays, if nearer than what `hits` has for them already.
    nearest_stream(
        tree: &WideTree,
        geometry: &Geometry,
        rays: &[Ray],
        pick: RaySelection,
        hits: &mut [Option<Hit>],
        scratch: &mut Scratch,
    ) = |level| if tree.has_instances() {
        ray_stream::trace::<_, Nearest, true, false>(level, tree, geometry, rays, pick, hits, scratch);
    } else {
        ray_stream::trace::<_, Nearest, false, false>(level, tree, geometry, rays, pick, hits, scratch);
    }
}

kernel! {
    /// Whether the rays meet anything; those that `blocked` says of are not asked.
    occluded_stream(
        tree: &WideTree,
        geometry: &Geometry,
        rays: &[Ray],
        pick: RaySelection,
        blocked: &mut [bool],
        scratch: &mut Scratch,
    ) -> StreamReport = |level| match pick {
        _ if tree.has_instances() => {
            ray_stream::trace::<_, Occluded, true, false>(level, tree, geometry, rays, pick, blocked, scratch)
        }
        RaySelection::Together(_) => {
            ray_stream::trace::<_, Occluded, false, true>(level, tree, geometry, rays, pick, blocked, scratch)
        }
        _ => ray_stream::trace::<_, Occluded, false, false>(level, tree, geometry, rays, pick, blocked, scratch),
    }
}

kernel! {
    /// Whether the rays meet anything, as far as that can be said at once; `order` says which start next to one another. Returns
    /// whether that pays: then the numbers of the others are in `remaining`. Not for scenes with instances.
    occluded_at_once(
        tree: &WideTree,
        rays: &[Ray],
        order: PacketOrder,
        blocked: &mut [bool],
        remaining: &mut Vec<u32>,
    ) -> bool = |level| occluder_cache::trace(level, tree, rays, order, blocked, remaining)
}

kernel! {
    /// The nearest hits of rays in packets of [`RAYS`], if nearer than what `hits` has for them already; `order` says which
    /// rays make a packet. The numbers of rays that are in none are put into `remaining`.
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
        packet::trace::<_, Nearest>(level, tree, geometry, batch, hits, remaining, scratch);
    }
}

kernel! {
    /// The same for whether the rays meet anything; those that `blocked` says of are not asked. Returns whether
    /// packets pay.
    occluded_packets(
        tree: &WideTree,
        geometry: &Geometry,
        batch: PacketBatch<'_>,
        blocked: &mut [bool],
        remaining: &mut Vec<u32>,
        scratch: &mut Scratch,
    ) -> bool = |level| {
        packet::trace::<_, Occluded>(level, tree, geometry, batch, blocked, remaining, scratch)
    }
}
