//! The binary tree that the others are made of, built by obvhs in parallel.
//!
//! Boxes are parted into *plots* of some thousand that lie together ([`partitions`]); obvhs builds a tree over each, on one
//! thread and in the cache ([`ploc`]). What is above them obvhs improves as one tree ([`upper_tree`]). What lies
//! below a node of that, up to some thousand primitives, is a *piece*: one thread brings it into depth-first
//! order, with arrays and numbers of its own, and hands it to what is to be made of it while it lies in the cache. A few primitives
//! are none, but belong to the tree above.
//!
//! Time is linear in the number of boxes but for the halving's few levels, whatever the boxes are. The tree depends on
//! the boxes alone, not on the number of threads.

use bvh2_tree::{Flat, Forest, Leaves, Tree};
use median_split::{Bounds, Ref};
use obvhs::bvh2::node::Bvh2Node;
use partitions::{Ground, Plot, part};
use ploc::Effort;
use prims::{Fate, Prims};
use rayon::prelude::*;
use spatial_split::Cutter;
use upper_tree::Crown;

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
    finish: impl Fn(Tree) -> T + Sync,
) -> Option<Forest<T>> {
    let (mut refs, bounds, fate) = (prims.refs, prims.around, prims.fate);
    if refs.is_empty() {
        return None;
    }
    let mut parts = Vec::new();
    if quality == Quality::High && fate == Fate::Fixed {
        let reach = prims.reach;
        parts = Cutter { geometry, reach }.cut(&refs, &bounds);
    }
    let ground = Ground {
        geometry,
        fate,
        scale: 1.0 / prims.reach.max(f32::MIN_POSITIVE),
        effort: Effort::new(quality),
    };
    let crown = Crown::new(plots(&mut refs, bounds, &ground), geometry, leaves);
    if parts.is_empty() {
        return Some(crown.pieces(finish));
    }
    // Whether cutting has made the tree better shows when it is there.
    let of_parts = Crown::new(plots(&mut parts, bounds, &ground), geometry, leaves);
    let better = if of_parts.cost() < crown.cost() {
        of_parts
    } else {
        crown
    };
    Some(better.pieces(finish))
}

/// Parts boxes into plots; the tree that these are the leaves of comes second.
fn plots<'a>(refs: &'a mut [Ref], bounds: Bounds, ground: &Ground<'_>) -> (Vec<Plot<'a>>, Vec<Bvh2Node>) {
    let (sets, above) = part(refs, bounds).flatten();
    let plots = sets.into_par_iter().with_max_len(1).map(|set| Plot::new(set, ground));
    (plots.collect(), above)
}

/// The same in one piece.
pub(super) fn build_tree(prims: Prims, geometry: &Geometry, quality: Quality, leaves: Leaves) -> Option<Tree> {
    build_forest(prims, geometry, quality, leaves, |tree| tree).map(join)
}

fn join(Forest { top, pieces }: Forest<Tree>) -> Tree {
    let mut whole = Tree::default();
    // A piece takes the place of one node; what was behind that moves.
    let mut starts = Vec::with_capacity(top.nodes.len());
    let mut next = 0;
    for node in &top.nodes {
        starts.push(next as u32);
        next += if node.count == Flat::PIECE {
            pieces[node.link as usize].nodes.len()
        } else {
            1
        };
    }
    whole.nodes.reserve_exact(next);
    for node in &top.nodes {
        match node.count {
            Flat::PIECE => whole.append(&pieces[node.link as usize]),
            Flat::INNER => {
                let link = starts[node.link as usize];
                whole.nodes.push(Flat { link, ..*node });
            }
            count => {
                let link = whole.ids.len() as u32;
                whole.nodes.push(Flat { link, ..*node });
                whole
                    .ids
                    .extend_from_slice(&top.ids[node.link as usize..][..count as usize]);
            }
        }
    }
    whole
}
