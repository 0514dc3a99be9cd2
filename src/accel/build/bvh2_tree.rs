//! Binary trees in depth-first order.

use crate::math::Aabb;

/// A node in depth-first order: the first child follows its parent, and all children come after
/// their parents.
#[derive(Clone, Copy, Debug)]
pub struct FlatNode {
    /// The bounds of the subtree.
    pub bounds: Aabb,
    /// The index of the second child, of a leaf's first element in [`Bvh2Tree::ids`], or of a
    /// piece.
    pub link: u32,
    /// The number of primitives in a leaf, [`FlatNode::INNER`] for an inner node, or
    /// [`FlatNode::PIECE`] for a piece.
    pub count: u32,
}

impl FlatNode {
    pub const INNER: u32 = 0;
    pub const PIECE: u32 = u32::MAX;

    /// An inner node whose second child and bounds are set later.
    pub const OPEN: Self = Self {
        bounds: Aabb::EMPTY,
        link: 0,
        count: Self::INNER,
    };

    pub fn is_leaf(&self) -> bool {
        self.count != Self::INNER
    }

    /// Sets the bounds of all inner nodes from those of their children.
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
pub struct Bvh2Tree {
    pub nodes: Vec<FlatNode>,
    /// The primitives of the leaves, in the order of the leaves.
    pub ids: Vec<u32>,
}

impl Bvh2Tree {
    /// Appends another tree.
    pub fn append(&mut self, other: &Self) {
        let (nodes, ids) = (self.nodes.len() as u32, self.ids.len() as u32);
        self.nodes.extend(other.nodes.iter().map(|node| FlatNode {
            link: node.link + if node.is_leaf() { ids } else { nodes },
            ..*node
        }));
        self.ids.extend_from_slice(&other.ids);
    }
}

/// A tree that has pieces among its leaves.
pub struct Forest<T> {
    pub top: Bvh2Tree,
    pub pieces: Vec<T>,
}

/// The contents of leaves.
#[derive(Clone, Copy, Debug)]
pub struct Leaves {
    /// The largest number of triangles. Other primitives have a leaf of their own.
    pub triangles: usize,
}
