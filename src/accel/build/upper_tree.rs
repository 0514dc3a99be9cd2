//! The tree above the partitions, and the assembly of the whole tree.
//!
//! At the borders of partitions, a tree is only as good as the split in halves was, and large
//! primitives such as walls are kept in their partition. So some thousand of the largest nodes of
//! all partitions become the leaves of one tree, the *upper tree*. Its initial topology is that of
//! the partitions and of the splits. Then all of its nodes are repeatedly reinserted at their best
//! positions.
//!
//! Below, the tree is brought into depth-first order piece by piece. Subtrees with no more
//! triangles than two blocks are rebuilt, since obvhs does not know that four triangles are tested
//! together.

use std::collections::BinaryHeap;

use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use rayon::prelude::*;

use super::{
    bvh2_tree::{Bvh2Tree, FlatNode, Forest, Leaves},
    median_split::{PrimBox, SetBounds, cut_few},
    partitions::{Partition, depth_first, sizes},
    reinsert::reinsert_all,
};
use crate::{geometry::Geometry, math::Aabb};

/// The number of primitives per leaf of the upper tree.
const PRIMS_PER_LEAF: usize = 128;

/// The largest number of leaves of the upper tree, which bounds its build time.
const MOST_LEAVES: usize = 1 << 14;

/// The number of reinsertion passes of the upper tree.
const PASSES: usize = 8;

/// The largest number of primitives in a piece.
const PIECE_PRIMS: u32 = 1 << 14;

/// The largest number of primitives of a subtree that is not a piece but a part of the tree above.
/// As a piece, walls would be one child, with the box of the room.
const MAX_INLINE_PRIMS: u32 = 64;

/// The largest number of triangles in a subtree that is rebuilt: two blocks.
const MAX_REORDERED_TRIANGLES: usize = 8;

/// A node of a partition.
#[derive(Clone, Copy)]
struct Place {
    partition: u32,
    node: u32,
}

/// Partitions and the tree above them.
pub struct UpperTree<'a> {
    partitions: Vec<Partition<'a>>,
    nodes: Vec<Bvh2Node>,
    /// The number of primitives below each node.
    sizes: Vec<u32>,
    /// The nodes of partitions that are the leaves, by their indices.
    places: Vec<Place>,
    geometry: &'a Geometry,
    leaves: Leaves,
}

/// A node of the whole tree.
#[derive(Clone, Copy)]
enum Node {
    UpperTree(u32),
    Below(Place),
}

impl<'a> UpperTree<'a> {
    /// Builds the upper tree over partitions, which are the leaves of a tree of nodes without
    /// boxes.
    pub fn new(
        (partitions, nodes): (Vec<Partition<'a>>, Vec<Bvh2Node>),
        geometry: &'a Geometry,
        leaves: Leaves,
    ) -> Self {
        let count: usize = partitions.iter().map(|partition| partition.refs.len()).sum();
        let (mut nodes, places) = grow(&partitions, nodes, (count / PRIMS_PER_LEAF).min(MOST_LEAVES));
        for i in (0..nodes.len()).rev() {
            if !nodes[i].is_leaf() {
                let first = nodes[i].first_index as usize;
                let around = nodes[first].aabb().union(nodes[first + 1].aabb());
                nodes[i].set_aabb(around);
            }
        }
        let mut tree = Bvh2 {
            nodes,
            primitive_indices: (0..places.len() as u32).collect(),
            ..Bvh2::default()
        };
        if partitions.len() > 1 {
            reinsert_all(&mut tree, PASSES);
        }
        let nodes = depth_first(&tree, |place| place);
        let sizes = sizes(&nodes, |leaf| {
            let Place { partition, node } = places[leaf as usize];
            partitions[partition as usize].sizes[node as usize]
        });
        Self {
            partitions,
            nodes,
            sizes,
            places,
            geometry,
            leaves,
        }
    }

    /// Returns the tree above the pieces, and the results of `finish` for these.
    pub fn pieces<T: Send>(&self, finish: impl Fn(Bvh2Tree) -> T + Sync) -> Forest<T> {
        let mut roots = Vec::new();
        let mut top = Bvh2Tree::default();
        let mut open = vec![(0_u32, None)];
        while let Some((index, parent)) = open.pop() {
            let at = top.nodes.len();
            if let Some(parent) = parent {
                top.nodes[parent as usize].link = at as u32;
            }
            let (node, size) = (&self.nodes[index as usize], self.sizes[index as usize]);
            if size <= MAX_INLINE_PRIMS && at > 0 {
                top.append(&self.flatten(self.node(index)));
            } else if node.is_leaf() || size <= PIECE_PRIMS {
                top.nodes.push(FlatNode {
                    bounds: Aabb::EMPTY,
                    link: roots.len() as u32,
                    count: FlatNode::PIECE,
                });
                roots.push(self.node(index));
            } else {
                open.extend([(node.first_index + 1, Some(at as u32)), (node.first_index, None)]);
                top.nodes.push(FlatNode::OPEN);
            }
        }
        let (boxes, pieces): (Vec<Aabb>, Vec<T>) = roots
            .into_par_iter()
            .with_max_len(1)
            .map(|root| {
                let tree = self.flatten(root);
                (tree.nodes[0].bounds, finish(tree))
            })
            .unzip();
        for node in &mut top.nodes {
            if node.count == FlatNode::PIECE {
                node.bounds = boxes[node.link as usize];
            }
        }
        FlatNode::enclose(&mut top.nodes);
        Forest { top, pieces }
    }

    fn node(&self, index: u32) -> Node {
        let node = &self.nodes[index as usize];
        if node.is_leaf() {
            Node::Below(self.places[node.first_index as usize])
        } else {
            Node::UpperTree(index)
        }
    }

    /// Returns the subtree at `root` in depth-first order, with the true boxes.
    fn flatten(&self, root: Node) -> Bvh2Tree {
        let mut tree = Bvh2Tree::default();
        let mut few = Vec::with_capacity(MAX_REORDERED_TRIANGLES);
        let mut open = vec![(root, None)];
        while let Some((node, parent)) = open.pop() {
            let at = tree.nodes.len() as u32;
            if let Some(parent) = parent {
                tree.nodes[parent as usize].link = at;
            }
            let children = match node {
                Node::UpperTree(index) => {
                    let first = self.nodes[index as usize].first_index;
                    [self.node(first), self.node(first + 1)]
                }
                Node::Below(place) => {
                    few.clear();
                    if self.are_few(place, &mut few) {
                        self.order(&mut few, &mut tree);
                        continue;
                    }
                    let first = self.partitions[place.partition as usize].nodes[place.node as usize].first_index;
                    [first, first + 1].map(|node| Node::Below(Place { node, ..place }))
                }
            };
            open.extend([(children[1], Some(at)), (children[0], None)]);
            tree.nodes.push(FlatNode::OPEN);
        }
        FlatNode::enclose(&mut tree.nodes);
        tree
    }

    /// Returns whether the subtree at `place` may be rebuilt or is a leaf. Then its primitives are
    /// added to `few`.
    fn are_few(&self, Place { partition, node }: Place, few: &mut Vec<PrimBox>) -> bool {
        let partition = &self.partitions[partition as usize];
        let size = partition.sizes[node as usize] as usize;
        if size > MAX_REORDERED_TRIANGLES {
            return false;
        }
        let mut open = [node; MAX_REORDERED_TRIANGLES];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let node = &partition.nodes[open[waiting] as usize];
            if node.is_leaf() {
                few.push(partition.refs[node.first_index as usize]);
            } else {
                (open[waiting], open[waiting + 1]) = (node.first_index + 1, node.first_index);
                waiting += 2;
            }
        }
        size == 1 || few.iter().all(|r| (r.index() as usize) < self.geometry.triangles.len())
    }

    /// Appends a tree over a few primitives.
    fn order(&self, few: &mut [PrimBox], tree: &mut Bvh2Tree) {
        if few.len() <= self.leaves.triangles {
            tree.nodes.push(FlatNode {
                bounds: SetBounds::of(few).boxes.aabb(),
                link: tree.ids.len() as u32,
                count: few.len() as u32,
            });
            tree.ids.extend(few.iter().map(PrimBox::index));
            return;
        }
        let at = tree.nodes.len();
        tree.nodes.push(FlatNode::OPEN);
        let middle = cut_few(few);
        let (left, right) = few.split_at_mut(middle);
        self.order(left, tree);
        tree.nodes[at].link = tree.nodes.len() as u32;
        self.order(right, tree);
    }
}

/// Extends a tree whose leaves are partitions into these, the largest nodes first, until it has
/// about `most` leaves.
fn grow(partitions: &[Partition<'_>], mut nodes: Vec<Bvh2Node>, most: usize) -> (Vec<Bvh2Node>, Vec<Place>) {
    let mut places: Vec<Place> = (0..partitions.len() as u32)
        .map(|partition| Place { partition, node: 0 })
        .collect();
    // Areas are not negative, so their bits sort like the floats.
    let entry = |node: &Bvh2Node, at: usize| (node.aabb().half_area().to_bits(), at);
    let mut open = BinaryHeap::new();
    for (at, node) in nodes.iter_mut().enumerate().filter(|(_, node)| node.is_leaf()) {
        node.set_aabb(*partitions[node.first_index as usize].nodes[0].aabb());
        open.push(entry(node, at));
    }
    while places.len() < most
        && let Some((_, at)) = open.pop()
    {
        let number = nodes[at].first_index as usize;
        let place = places[number];
        let partition = &partitions[place.partition as usize];
        let node = &partition.nodes[place.node as usize];
        if node.is_leaf() || partition.same {
            continue;
        }
        let first = nodes.len();
        nodes[at].make_inner(first as u32);
        places[number].node = node.first_index;
        places.push(Place {
            node: node.first_index + 1,
            ..place
        });
        for (k, number) in [number, places.len() - 1].into_iter().enumerate() {
            let child = &partition.nodes[places[number].node as usize];
            nodes.push(Bvh2Node::new(*child.aabb(), 1, number as u32));
            open.push(entry(child, first + k));
        }
    }
    (nodes, places)
}
