//! The binary tree that the others are made of, built by obvhs in parallel.
//!
//! Boxes are parted into *partitions* of some thousand that lie together ([`partitions`]); obvhs builds a tree over each, on one
//! thread and in the cache ([`ploc`]). What is above them obvhs improves as one tree ([`upper_tree`]). What lies
//! below a node of that, up to some thousand primitives, is a *piece*: one thread brings it into depth-first
//! order, with arrays and numbers of its own, and hands it to what is to be made of it while it lies in the cache. A few primitives
//! are none, but belong to the tree above.
//!
//! Time is linear in the number of boxes but for the halving's few levels, whatever the boxes are. The tree depends on
//! the boxes alone, not on the number of threads.

use bvh2_tree::{Bvh2Tree, FlatNode, Forest, Leaves};
use median_split::{PrimBox, SetBounds};
use obvhs::bvh2::node::Bvh2Node;
use partitions::{Partition, PartitionContext, part};
use ploc::BuildPreset;
use prims::{Mobility, Prims};
use rayon::prelude::*;
use spatial_split::SpatialSplitter;
use upper_tree::UpperTree;

use super::accelerator::Quality;
use crate::geometry::Geometry;

pub(super) mod bvh2_tree;
mod median_split;
mod partitions;
mod ploc;
pub(super) mod prims;
mod reinsert;
mod spatial_split;
mod upper_tree;

/// A tree over `prims`, of whose pieces `finish` makes what is kept of them. `None` where there are none.
pub(super) fn build_forest<T: Send>(
    prims: Prims,
    geometry: &Geometry,
    quality: Quality,
    leaves: Leaves,
    finish: impl Fn(Bvh2Tree) -> T + Sync,
) -> Option<Forest<T>> {
    let (mut refs, bounds, mobility) = (prims.refs, prims.around, prims.mobility);
    if refs.is_empty() {
        return None;
    }
    let mut parts = Vec::new();
    if quality == Quality::High && mobility == Mobility::Fixed {
        let reach = prims.reach;
        parts = SpatialSplitter { geometry, reach }.cut(&refs, &bounds);
    }
    let context = PartitionContext {
        geometry,
        mobility,
        scale: 1.0 / prims.reach.max(f32::MIN_POSITIVE),
        preset: BuildPreset::new(quality),
    };
    let upper_tree = UpperTree::new(partitions(&mut refs, bounds, &context), geometry, leaves);
    if parts.is_empty() {
        return Some(upper_tree.pieces(finish));
    }
    // Whether cutting has made the tree better shows when it is there.
    let of_parts = UpperTree::new(partitions(&mut parts, bounds, &context), geometry, leaves);
    let better = if of_parts.cost() < upper_tree.cost() {
        of_parts
    } else {
        upper_tree
    };
    Some(better.pieces(finish))
}

/// Parts boxes into partitions; the tree that these are the leaves of comes second.
fn partitions<'a>(
    refs: &'a mut [PrimBox],
    bounds: SetBounds,
    context: &PartitionContext<'_>,
) -> (Vec<Partition<'a>>, Vec<Bvh2Node>) {
    let (sets, above) = part(refs, bounds).flatten();
    let partitions = sets
        .into_par_iter()
        .with_max_len(1)
        .map(|set| Partition::new(set, context));
    (partitions.collect(), above)
}

/// The same in one piece.
pub(super) fn build_tree(prims: Prims, geometry: &Geometry, quality: Quality, leaves: Leaves) -> Option<Bvh2Tree> {
    build_forest(prims, geometry, quality, leaves, |tree| tree).map(join)
}

fn join(Forest { top, pieces }: Forest<Bvh2Tree>) -> Bvh2Tree {
    let mut whole = Bvh2Tree::default();
    // A piece takes the place of one node; what was behind that moves.
    let mut starts = Vec::with_capacity(top.nodes.len());
    let mut next = 0;
    for node in &top.nodes {
        starts.push(next as u32);
        next += if node.count == FlatNode::PIECE {
            pieces[node.link as usize].nodes.len()
        } else {
            1
        };
    }
    whole.nodes.reserve_exact(next);
    for node in &top.nodes {
        match node.count {
            FlatNode::PIECE => whole.append(&pieces[node.link as usize]),
            FlatNode::INNER => {
                let link = starts[node.link as usize];
                whole.nodes.push(FlatNode { link, ..*node });
            }
            count => {
                let link = whole.ids.len() as u32;
                whole.nodes.push(FlatNode { link, ..*node });
                whole
                    .ids
                    .extend_from_slice(&top.ids[node.link as usize..][..count as usize]);
            }
        }
    }
    whole
}
