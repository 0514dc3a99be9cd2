//! Validated wide trees, which the kernels index without bounds checks.

use std::{ops::Range, slice};

use crate::{
    accel::wide::node::{self, EMPTY, LEAF, SHAPE, TriangleBlock, WideNode},
    geometry::padding::BoundsPadding,
};

/// The nodes and blocks of one or more trees.
///
/// The trees are concatenated: those of the groups in order, that of the static triangles, and the
/// top-level tree. The latter is the last one because it is the one that changes. Each tree is
/// validated when it is added; afterwards, only its boxes change. An inner child comes after its
/// node, so there are no cycles and [`WideTree::stack_len`] is a bound, or it is the root of the
/// static triangles. A leaf's blocks exist, the id of a shape is below the number of primitives,
/// and that of an instance is below the number of instances.
#[derive(Clone, Default)]
pub struct WideTree {
    pub(super) nodes: Vec<WideNode>,
    pub(super) blocks: Vec<TriangleBlock>,
    pub(super) sections: Vec<Section>,
    /// Whether there are groups.
    has_instances: bool,
    pub padding: BoundsPadding,
}

/// One of the trees.
#[derive(Clone, Debug)]
pub(super) struct Section {
    pub nodes: Range<usize>,
    pub blocks: Range<usize>,
    depth: usize,
    /// The expected traversal cost at the time of the build, once it has been computed.
    pub cost: Option<f32>,
}

/// A tree with its own indices, whose root is node 0; empty if there are no primitives.
pub type BuiltTree = (Vec<WideNode>, Vec<TriangleBlock>);

/// The meaning of the ids in a tree; see [`crate::accel::build::prims::Item`].
#[derive(Clone, Copy, Debug)]
pub struct IdSpace {
    pub prims: usize,
    pub instances: usize,
    /// The index of the tree of the static triangles among the previous trees.
    pub static_tree: Option<usize>,
}

impl IdSpace {
    /// Returns the id space of a tree that has only primitives.
    pub fn prims(prims: usize) -> Self {
        Self {
            prims,
            instances: 0,
            static_tree: None,
        }
    }
}

impl WideTree {
    /// Appends a tree; the last one is the top-level tree. Returns `None` if the arrays are not a
    /// valid tree.
    pub fn push(&mut self, (mut nodes, blocks): BuiltTree, numbers: IdSpace) -> Option<()> {
        let (first_node, first_block) = (self.nodes.len(), self.blocks.len());
        if first_node + nodes.len() > node::MAX_NODES || first_block + blocks.len() > node::MAX_BLOCKS {
            return None;
        }
        let mut levels = vec![1_usize; nodes.len()];
        let mut depth = 1;
        for i in 0..nodes.len() {
            let level = levels[i] + 1;
            for child in &mut nodes[i].child {
                if *child == EMPTY {
                } else if *child & LEAF == 0 {
                    let inner = node::index(*child);
                    if inner <= i || inner >= levels.len() || *child != node::inner(inner) {
                        return None;
                    }
                    levels[inner] = levels[inner].max(level);
                    depth = depth.max(level);
                } else if *child & SHAPE == 0 {
                    let range = node::blocks(*child);
                    if range.end > blocks.len() || *child != node::leaf(range.start, range.len()) {
                        return None;
                    }
                } else {
                    *child = self.item(node::number(*child) as usize, &numbers)?;
                    continue;
                }
                *child = node::moved(*child, first_node as isize, first_block as isize);
            }
        }
        let (node_count, block_count) = (nodes.len(), blocks.len());
        if first_node == 0 && first_block == 0 {
            (self.nodes, self.blocks) = (nodes, blocks);
        } else {
            self.nodes.extend(nodes);
            self.blocks.extend(blocks);
        }
        self.has_instances |= numbers.instances > 0;
        self.sections.push(Section {
            nodes: first_node..first_node + node_count,
            blocks: first_block..first_block + block_count,
            depth,
            cost: None,
        });
        Some(())
    }

    /// Returns the child for an item.
    fn item(&self, item: usize, numbers: &IdSpace) -> Option<u32> {
        if item < numbers.prims {
            return Some(node::shape(item as u32));
        }
        let instance = item - numbers.prims;
        if instance < numbers.instances {
            return Some(node::instance(instance as u32));
        }
        let static_tree = self.sections.get(numbers.static_tree?)?;
        (!static_tree.nodes.is_empty()).then(|| node::inner(static_tree.nodes.start))
    }

    /// Removes the last tree.
    pub fn pop(&mut self) {
        if let Some(last) = self.sections.pop() {
            self.nodes.truncate(last.nodes.start);
            self.blocks.truncate(last.blocks.start);
        }
    }

    /// Replaces a tree of primitives that is followed by such trees only. Returns `None` if the
    /// arrays are not a valid tree.
    pub fn replace(&mut self, section: usize, built_tree: BuiltTree, numbers: IdSpace) -> Option<()> {
        let mut behind = Vec::new();
        while self.sections.len() > section {
            behind.push(self.last());
            self.pop();
        }
        behind.pop();
        behind.push(built_tree);
        while let Some(built_tree) = behind.pop() {
            self.push(built_tree, numbers)?;
        }
        Some(())
    }

    /// Returns the last tree, with its own indices.
    fn last(&self) -> BuiltTree {
        let Some(last) = self.sections.last() else {
            return BuiltTree::default();
        };
        let mut nodes = self.nodes[last.nodes.clone()].to_vec();
        for child in nodes.iter_mut().flat_map(|node| &mut node.child) {
            *child = node::moved(*child, -(last.nodes.start as isize), -(last.blocks.start as isize));
        }
        (nodes, self.blocks[last.blocks.clone()].to_vec())
    }

    /// Returns the root of the top-level tree.
    #[inline(always)]
    pub fn root(&self) -> u32 {
        self.sections.last().map_or(0, |top| node::inner(top.nodes.start))
    }

    /// Returns the root of a group's tree.
    #[inline(always)]
    pub fn group_root(&self, group: u32) -> u32 {
        node::inner(self.sections[group as usize].nodes.start)
    }

    pub fn has_instances(&self) -> bool {
        self.has_instances
    }

    pub fn nodes(&self) -> &[WideNode] {
        &self.nodes
    }

    pub fn blocks(&self) -> &[TriangleBlock] {
        &self.blocks
    }

    /// Returns the largest number of children that wait on a ray's stack: on every level but the
    /// last, all children except the visited one; on the last level, all; the end marker and the
    /// root of an instance; and one more store of eight.
    pub fn stack_len(&self) -> usize {
        let below = self.sections.iter().rev().skip(1).map(|s| s.depth).max();
        let depth = self.sections.last().map_or(0, |top| top.depth) + below.unwrap_or(0);
        7 * depth + 1 + 2 + 8
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.blocks[..])
    }

    /// # Safety
    /// `child` is a root or an inner child of one of this tree's nodes.
    #[inline(always)]
    pub unsafe fn node(&self, child: u32) -> &WideNode {
        debug_assert!(node::index(child) < self.nodes.len());
        // SAFETY: the first node exists, and inner children exist.
        unsafe { &*self.nodes.as_ptr().byte_add(node::node_offset(child)) }
    }

    /// # Safety
    /// `child` is a leaf of one of this tree's nodes.
    #[inline(always)]
    pub unsafe fn leaf(&self, child: u32) -> &[TriangleBlock] {
        debug_assert!(node::blocks(child).end <= self.blocks.len());
        // SAFETY: the blocks of leaves exist.
        unsafe {
            let first = self.blocks.as_ptr().byte_add(node::offset(child));
            slice::from_raw_parts(first, node::count(child))
        }
    }

    pub fn starts(&self) -> Starts {
        Starts([self.nodes.as_ptr().cast(), self.blocks.as_ptr().cast()])
    }
}

/// The addresses of the first node and the first block.
pub struct Starts([*const u8; 2]);

impl Starts {
    /// Returns an address in the first cache line of the child's data. It is for prefetching only
    /// and must not be read.
    #[inline(always)]
    pub fn of(&self, child: u32) -> *const u8 {
        self.0[(child & LEAF) as usize].wrapping_add(node::offset_nearly(child))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_that_do_not_exist_are_refused() {
        let with = |child: u32| {
            let mut first = WideNode::NOTHING;
            first.child[3] = child;
            let built_tree = (vec![first, WideNode::NOTHING], vec![TriangleBlock::NOTHING; 3]);
            WideTree::default().push(built_tree, IdSpace::prims(5)).is_some()
        };
        assert!(with(node::inner(1)) && with(node::leaf(0, 3)) && with(node::shape(4)) && with(EMPTY));
        assert!(
            !with(node::inner(0))
                && !with(node::inner(2))
                && !with(node::inner(1) | node::INSTANCE)
                && !with(node::inner(1) / 2)
                && !with(node::leaf(1, 3))
                && !with(node::shape(5))
        );
    }

    /// Returns a root with an inner child and a leaf.
    fn built_tree(blocks: usize) -> BuiltTree {
        let mut first = WideNode::NOTHING;
        first.child[0] = node::inner(1);
        first.child[1] = node::leaf(blocks - 1, 1);
        (vec![first, WideNode::NOTHING], vec![TriangleBlock::NOTHING; blocks])
    }

    #[test]
    fn numbers_move_with_their_trees() {
        let mut tree = WideTree::default();
        let numbers = IdSpace::prims(5);
        for blocks in [1, 2, 3] {
            tree.push(built_tree(blocks), numbers).expect("a tree");
        }
        let children = |tree: &WideTree| [0, 2, 4].map(|i| [tree.nodes[i].child[0], tree.nodes[i].child[1]]);
        assert_eq!(
            children(&tree),
            [
                [node::inner(1), node::leaf(0, 1)],
                [node::inner(3), node::leaf(2, 1)],
                [node::inner(5), node::leaf(5, 1)]
            ]
        );
        tree.replace(1, built_tree(4), numbers).expect("a tree");
        assert_eq!(
            children(&tree),
            [
                [node::inner(1), node::leaf(0, 1)],
                [node::inner(3), node::leaf(4, 1)],
                [node::inner(5), node::leaf(7, 1)]
            ]
        );
        tree.pop();
        assert_eq!(
            (tree.nodes.len(), tree.blocks.len(), tree.root()),
            (4, 5, node::inner(2))
        );
    }

    #[test]
    fn items_of_the_top_become_instances_and_the_still_tree() {
        let mut tree = WideTree::default();
        tree.push(built_tree(1), IdSpace::prims(5)).expect("a tree");
        let mut top = WideNode::NOTHING;
        for (lane, item) in [4, 5, 7].into_iter().enumerate() {
            top.child[lane] = node::shape(item);
        }
        let numbers = |instances, static_tree| IdSpace {
            prims: 5,
            instances,
            static_tree,
        };
        assert!(tree.push((vec![top], vec![]), numbers(2, None)).is_none());
        tree.push((vec![top], vec![]), numbers(2, Some(0))).expect("a tree");
        assert_eq!(tree.nodes[2].child[..3], [node::shape(4), node::instance(0), 0]);
        assert!(tree.has_instances());
    }
}
