//! The binary tree that the others are made of, built by obvhs in parallel.
//!
//! Boxes are parted into *plots* of some thousand that lie together ([`super::plots`]); obvhs builds a tree over each, on one
//! thread and in the cache ([`super::ploc`]). What is above them obvhs improves as one tree ([`super::crown`]). What lies
//! below a node of that, up to some thousand primitives, is a *piece*: one thread brings it into depth-first
//! order, with arrays and numbers of its own, and hands it to what is to be made of it while it lies in the cache. A few primitives
//! are none, but belong to the tree above.
//!
//! Time is linear in the number of boxes but for the halving's few levels, whatever the boxes are. The tree depends on
//! the boxes alone, not on the number of threads.

use obvhs::bvh2::node::Bvh2Node;
use rayon::prelude::*;

use super::{
    Geometry, Quality,
    crown::Crown,
    ploc::Effort,
    plots::{Ground, Plot, part},
    prims::{Fate, Prims},
    sets::{Bounds, Ref},
    spatial::Cutter,
};
use crate::math::Aabb;

/// A node of a tree in depth-first order: a node's first child follows it, and all children come after their parents.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flat {
    /// The box around everything below.
    pub bounds: Aabb,
    /// Of a node with children the second one's index, of a leaf its first place in [`Tree::ids`], or a piece's number.
    pub link: u32,
    /// How many primitives a leaf holds, [`Flat::INNER`] for a node with children, [`Flat::PIECE`] for a piece.
    pub count: u32,
}

impl Flat {
    pub const INNER: u32 = 0;
    pub const PIECE: u32 = u32::MAX;

    /// With children, which come later, as the box does.
    pub const OPEN: Self = Self {
        bounds: Aabb::EMPTY,
        link: 0,
        count: Self::INNER,
    };

    pub fn is_leaf(&self) -> bool {
        self.count != Self::INNER
    }

    /// Gives every node with children the box around theirs.
    pub fn enclose(nodes: &mut [Self]) {
        for i in (0..nodes.len()).rev() {
            if !nodes[i].is_leaf() {
                nodes[i].bounds = nodes[i + 1].bounds.union(nodes[nodes[i].link as usize].bounds);
            }
        }
    }
}

/// A binary tree.
#[derive(Default)]
pub(super) struct Tree {
    pub nodes: Vec<Flat>,
    /// The leaves' primitives, in the order of the leaves.
    pub ids: Vec<u32>,
}

impl Tree {
    /// Adds another one behind it.
    pub fn append(&mut self, other: &Self) {
        let (nodes, ids) = (self.nodes.len() as u32, self.ids.len() as u32);
        self.nodes.extend(other.nodes.iter().map(|node| Flat {
            link: node.link + if node.is_leaf() { ids } else { nodes },
            ..*node
        }));
        self.ids.extend_from_slice(&other.ids);
    }
}

/// A tree among whose leaves are pieces.
pub(super) struct Forest<T> {
    pub top: Tree,
    pub pieces: Vec<T>,
}

/// What goes into a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaves {
    /// The most triangles. Of anything else there is one.
    pub triangles: usize,
}

/// A tree over `prims`, of whose pieces `finish` makes what is kept of them. `None` where there are none.
pub(super) fn build<T: Send>(
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
pub(super) fn build_whole(prims: Prims, geometry: &Geometry, quality: Quality, leaves: Leaves) -> Option<Tree> {
    build(prims, geometry, quality, leaves, |tree| tree).map(join)
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
