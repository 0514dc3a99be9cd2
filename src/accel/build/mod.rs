//! Parallel construction of the binary tree that the other trees are derived from.
//!
//! The boxes are divided into *partitions* of some thousand boxes that are close to each other
//! ([`mod@partitions`]). obvhs builds a tree over each, on one thread and in the cache ([`ploc`]). The
//! tree above them is optimised as a whole ([`upper_tree`]). A subtree of that tree with up to some
//! thousand primitives is a *piece*: one thread brings it into depth-first order, with its own
//! arrays and indices, and passes it to the next stage while it is in the cache. Subtrees of a few
//! primitives are not pieces but a part of the tree above.
//!
//! The time is linear in the number of boxes, except for the few levels of splitting, for any
//! input. The tree depends on the boxes only, not on the number of threads.

use bvh2_tree::{Bvh2Tree, FlatNode, Forest, Leaves};
use median_split::{PrimBox, SetBounds};
use obvhs::bvh2::node::Bvh2Node;
use partitions::{Partition, PartitionContext, part};
use prims::Prims;
use rayon::prelude::*;
use upper_tree::UpperTree;

use crate::geometry::Geometry;

pub(super) mod bvh2_tree;
mod median_split;
mod partitions;
mod ploc;
pub(super) mod prims;
mod reinsert;
mod upper_tree;

/// Builds a tree over `prims`, and calls `finish` on each of its pieces. Returns `None` if there
/// are no primitives.
pub(super) fn build_forest<T: Send>(
    prims: Prims,
    geometry: &Geometry,
    leaves: Leaves,
    finish: impl Fn(Bvh2Tree) -> T + Sync,
) -> Option<Forest<T>> {
    let (mut refs, bounds, mobility) = (prims.refs, prims.around, prims.mobility);
    if refs.is_empty() {
        return None;
    }
    let context = PartitionContext {
        geometry,
        mobility,
        scale: 1.0 / prims.reach.max(f32::MIN_POSITIVE),
    };
    let upper_tree = UpperTree::new(partitions(&mut refs, bounds, &context), geometry, leaves);
    Some(upper_tree.pieces(finish))
}

/// Divides boxes into partitions. Returns them and the tree above them.
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

/// Builds the same tree in one piece.
pub(super) fn build_tree(prims: Prims, geometry: &Geometry, leaves: Leaves) -> Option<Bvh2Tree> {
    build_forest(prims, geometry, leaves, |tree| tree).map(join)
}

fn join(Forest { top, pieces }: Forest<Bvh2Tree>) -> Bvh2Tree {
    let mut whole = Bvh2Tree::default();
    // A piece replaces one node, so the nodes after it move.
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
