//! A wide tree that was checked: what the kernels index without asking.

use super::super::wide::node::{self, Block, DONE, EMPTY, LEAF, Node, SHAPE};

/// Nodes and blocks whose every child exists.
///
/// Checked when it is made, and not changed afterwards: an inner child comes after its node (so there are no cycles, and
/// [`Tree::stack_len`] holds), a leaf's blocks exist, a shape's number is below the number of primitives.
pub struct Tree {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
    depth: usize,
    /// The largest coordinate, see [`super::super::slab::Planes::new`].
    pub reach: f32,
}

impl Tree {
    /// `None` where the arrays do not make a tree.
    pub fn new(nodes: Vec<Node>, blocks: Vec<Block>, prims: usize, reach: f32) -> Option<Self> {
        if nodes.is_empty() || nodes.len() >= DONE as usize >> 3 {
            return None;
        }
        let mut levels = vec![1_u32; nodes.len()];
        let mut depth = 1;
        for (i, node) in nodes.iter().enumerate() {
            let level = levels[i] + 1;
            for &child in &node.child {
                let exists = if child == EMPTY {
                    true
                } else if child & LEAF == 0 {
                    let child = child as usize;
                    let exists = child > i && child < nodes.len();
                    if exists {
                        levels[child] = levels[child].max(level);
                        depth = depth.max(level);
                    }
                    exists
                } else if child & SHAPE == 0 {
                    node::blocks(child).end <= blocks.len()
                } else {
                    ((child & !(LEAF | SHAPE)) as usize) < prims
                };
                if !exists {
                    return None;
                }
            }
        }
        Some(Self {
            nodes,
            blocks,
            depth: depth as usize,
            reach,
        })
    }

    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// How many children a ray can leave waiting: of each level above the last all but the one it is in, and all of the
    /// last; and one more store of eight.
    pub fn stack_len(&self) -> usize {
        7 * self.depth + 1 + 8
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.blocks[..])
    }

    /// # Safety
    /// `child` is 0 or an inner child of one of this tree's nodes.
    #[inline(always)]
    pub unsafe fn node(&self, child: u32) -> &Node {
        debug_assert!((child as usize) < self.nodes.len());
        // SAFETY: there is a first node, and inner children exist.
        unsafe { self.nodes.get_unchecked(child as usize) }
    }

    /// # Safety
    /// `index` comes from [`node::blocks`] of a leaf of one of this tree's nodes.
    #[inline(always)]
    pub unsafe fn block(&self, index: usize) -> &Block {
        debug_assert!(index < self.blocks.len());
        // SAFETY: leaves' blocks exist.
        unsafe { self.blocks.get_unchecked(index) }
    }

    /// Where the child's data begins, for a prefetch; nothing may be read there.
    #[inline(always)]
    pub fn address(&self, child: u32) -> *const u8 {
        let index = (child & !(LEAF | SHAPE)) as usize;
        let node = self.nodes.as_ptr().wrapping_add(index).cast::<u8>();
        let block = self.blocks.as_ptr().wrapping_add(index >> 2).cast::<u8>();
        if child & LEAF == 0 { node } else { block }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_that_do_not_exist_are_refused() {
        let with = |child: u32| {
            let mut first = Node::NOTHING;
            first.child[3] = child;
            Tree::new(vec![first, Node::NOTHING], vec![Block::NOTHING; 3], 5, 1.0).is_some()
        };
        assert!(with(1) && with(node::leaf(0, 3)) && with(LEAF | SHAPE | 4) && with(EMPTY));
        assert!(!with(0) && !with(2) && !with(node::leaf(1, 3)) && !with(LEAF | SHAPE | 5));
    }
}
