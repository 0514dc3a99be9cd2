//! Binary trees in depth-first order.

use crate::math::Aabb;

/// A node of a tree in depth-first order: a node's first child follows it, and all children come after their parents.
#[derive(Clone, Copy, Debug)]
pub struct FlatNode {
    /// The box around everything below.
    pub bounds: Aabb,
    /// Of a node with children the second one's index, of a leaf its first place in [`Bvh2Tree::ids`], or a piece's number.
    pub link: u32,
    /// How many primitives a leaf holds, [`FlatNode::INNER`] for a node with children, [`FlatNode::PIECE`] for a piece.
    pub count: u32,
}

impl FlatNode {
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
pub struct Bvh2Tree {
    pub nodes: Vec<FlatNode>,
    /// The leaves' primitives, in the order of the leaves.
    pub ids: Vec<u32>,
}

impl Bvh2Tree {
    /// Adds another one behind it.
    pub fn append(&mut self, other: &Self) {
        let (nodes, ids) = (self.nodes.len() as u32, self.ids.len() as u32);
        self.nodes.extend(other.nodes.iter().map(|node| FlatNode {
            link: node.link + if node.is_leaf() { ids } else { nodes },
            ..*node
        }));
        self.ids.extend_from_slice(&other.ids);
    }
}

/// A tree among whose leaves are pieces.
pub struct Forest<T> {
    pub top: Bvh2Tree,
    pub pieces: Vec<T>,
}

/// What goes into a leaf.
#[derive(Clone, Copy, Debug)]
pub struct Leaves {
    /// The most triangles. Of anything else there is one.
    pub triangles: usize,
}
