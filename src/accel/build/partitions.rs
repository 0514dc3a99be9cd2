//! Partitions: sets of some thousand boxes that are close to each other, with a tree by obvhs over
//! each.
//!
//! Sets are split in halves by count, along the axis of the largest extent of their centres, until
//! they fit into the cache. So obvhs gets a bounded number of boxes at once, for any input. Boxes
//! that have the same centre could take obvhs a long time; such a set is split by size down to its
//! leaves instead. There, triangles with the same vertices as an earlier one are removed: the
//! earlier one wins at the same `t` anyway.

use obvhs::{
    aabb::Aabb as Box3,
    bvh2::{Bvh2, node::Bvh2Node},
};
use rayon::prelude::*;

use super::{
    median_split::{PrimBox, SetBounds, halve},
    ploc,
    prims::Mobility,
};
use crate::geometry::Geometry;

/// The largest number of boxes in a partition.
const MAX_PARTITION: usize = 1 << 14;

/// The number of boxes from which partitions are half as large. The working set of a partition then
/// fits into the L2 cache, and the upper tree has enough partitions to repair their borders.
const MIN_LEN_OF_HALF_PARTITIONS: usize = 1 << 18;

/// The division of boxes into partitions.
pub enum PartitionTree<'a> {
    Set(Set<'a>),
    Halves(Box<[PartitionTree<'a>; 2]>),
}

/// Boxes that are close to each other.
pub struct Set<'a> {
    refs: &'a mut [PrimBox],
    /// Whether all have the same centre.
    same: bool,
}

/// Divides boxes into sets of at most [`MAX_PARTITION`] or half as many boxes, or of boxes with one
/// centre.
pub fn part(refs: &mut [PrimBox], bounds: SetBounds) -> PartitionTree<'_> {
    let most = if refs.len() < MIN_LEN_OF_HALF_PARTITIONS {
        MAX_PARTITION
    } else {
        MAX_PARTITION / 2
    };
    part_to(most, refs, bounds)
}

fn part_to(most: usize, refs: &mut [PrimBox], bounds: SetBounds) -> PartitionTree<'_> {
    let same = refs.len() > 2 && bounds.is_point();
    if same || refs.len() <= most {
        return PartitionTree::Set(Set { refs, same });
    }
    let middle = halve(refs, &bounds);
    let (left, right) = refs.split_at_mut(middle);
    let (a, b) = (SetBounds::of(left), SetBounds::of(right));
    let (left, right) = rayon::join(|| part_to(most, left, a), || part_to(most, right, b));
    PartitionTree::Halves(Box::new([left, right]))
}

impl<'a> PartitionTree<'a> {
    /// Returns the sets and the tree above them, whose leaves hold their indices; its boxes are not
    /// set yet.
    pub fn flatten(self) -> (Vec<Set<'a>>, Vec<Bvh2Node>) {
        let nothing = Bvh2Node::new(Box3::INVALID, 0, 0);
        let (mut sets, mut nodes) = (Vec::new(), vec![nothing]);
        let mut open = vec![(self, 0)];
        while let Some((parted, at)) = open.pop() {
            match parted {
                Self::Set(set) => {
                    nodes[at] = Bvh2Node::new(Box3::INVALID, 1, sets.len() as u32);
                    sets.push(set);
                }
                Self::Halves(halves) => {
                    let first = nodes.len();
                    nodes[at].first_index = first as u32;
                    nodes.extend([nothing; 2]);
                    let [left, right] = *halves;
                    open.extend([(right, first + 1), (left, first)]);
                }
            }
        }
        (sets, nodes)
    }
}

/// A tree over some of the boxes.
pub struct Partition<'a> {
    pub refs: &'a [PrimBox],
    /// The nodes in the layout of obvhs, over proxies, in depth-first order. Siblings are adjacent,
    /// and leaves hold an index into `refs`.
    pub nodes: Vec<Bvh2Node>,
    /// The number of leaves below each node.
    pub sizes: Vec<u32>,
    /// Whether all boxes have one centre.
    pub same: bool,
}

/// The inputs that all partitions share.
pub struct PartitionContext<'a> {
    pub geometry: &'a Geometry,
    pub mobility: Mobility,
    /// The factor that scales the scene to unit size.
    pub scale: f32,
}

impl<'a> Partition<'a> {
    pub fn new(set: Set<'a>, context: &PartitionContext<'_>) -> Self {
        if set.same {
            return Self::halved(set.refs, context);
        }
        let proxy = |r: &PrimBox| ploc::proxy(&r.bounds(), context.scale, r.index());
        let proxies: Vec<Box3> = set.refs.iter().map(proxy).collect();
        Self::over(set.refs, &ploc::build(&proxies), false)
    }

    /// Sorts the boxes by the leaves of the tree. This is done here, while the tree is still in the
    /// cache.
    fn over(refs: &'a mut [PrimBox], tree: &Bvh2, same: bool) -> Self {
        let before = refs.to_vec();
        let mut next = 0..;
        let nodes = depth_first(tree, |old| {
            let new = next.next().expect("there is always another number");
            refs[new as usize] = before[old as usize];
            new
        });
        Self {
            refs,
            sizes: sizes(&nodes, |_| 1),
            nodes,
            same,
        }
    }

    /// Builds a tree over boxes with one centre, by their size.
    fn halved(refs: &'a mut [PrimBox], context: &PartitionContext<'_>) -> Self {
        let kept = match context.mobility {
            Mobility::Fixed => drop_copies(refs, context.geometry),
            Mobility::Moving => refs.len(),
        };
        let refs = &mut refs[..kept];
        let bounds = SetBounds::of(refs);
        let around = ploc::proxy(&bounds.boxes.aabb(), context.scale, 0);
        let mut nodes = vec![Bvh2Node::new(around, 0, 0)];
        let mut open = vec![(0, 0..refs.len())];
        while let Some((at, range)) = open.pop() {
            if range.len() == 1 {
                nodes[at] = Bvh2Node::new(around, 1, range.start as u32);
                continue;
            }
            let middle = range.start + halve(&mut refs[range.clone()], &bounds);
            let first = nodes.len();
            nodes[at].first_index = first as u32;
            nodes.extend([Bvh2Node::new(around, 0, 0); 2]);
            open.extend([(first, range.start..middle), (first + 1, middle..range.end)]);
        }
        let tree = Bvh2 {
            nodes,
            primitive_indices: (0..kept as u32).collect(),
            ..Bvh2::default()
        };
        Self::over(refs, &tree, true)
    }
}

/// Returns the nodes of a tree in depth-first order, with siblings adjacent. `leaf` maps the index
/// that a leaf holds; it is called in the order of the leaves.
pub fn depth_first(tree: &Bvh2, mut leaf: impl FnMut(u32) -> u32) -> Vec<Bvh2Node> {
    let mut nodes = Vec::with_capacity(tree.nodes.len());
    nodes.push(tree.nodes[0]);
    let mut open = vec![0];
    while let Some(at) = open.pop() {
        let next = nodes.len();
        let node: &mut Bvh2Node = &mut nodes[at];
        let first = node.first_index as usize;
        if node.is_leaf() {
            node.first_index = leaf(tree.primitive_indices[first]);
        } else {
            node.first_index = next as u32;
            nodes.extend_from_slice(&tree.nodes[first..first + 2]);
            open.extend([next + 1, next]);
        }
    }
    nodes
}

/// Returns the size of each node's subtree. Parents come before their children; `size` gives that
/// of a leaf by its index.
pub fn sizes(nodes: &[Bvh2Node], size: impl Fn(u32) -> u32) -> Vec<u32> {
    let mut sizes = vec![0; nodes.len()];
    for (at, node) in nodes.iter().enumerate().rev() {
        sizes[at] = if node.is_leaf() {
            size(node.first_index)
        } else {
            let first = node.first_index as usize;
            sizes[first] + sizes[first + 1]
        };
    }
    sizes
}

/// Moves triangles that equal one with a lower id to the end. Returns the number of the other
/// triangles.
fn drop_copies(refs: &mut [PrimBox], geometry: &Geometry) -> usize {
    let key = |r: &PrimBox| {
        let index = r.index() as usize;
        let corners = (index < geometry.triangles.len()).then(|| {
            geometry
                .corners(index)
                .map(|corner| corner.to_array().map(f32::to_bits))
        });
        (corners, index)
    };
    refs.par_sort_unstable_by_key(key);
    let mut kept = 1;
    for i in 1..refs.len() {
        let (corners, _) = key(&refs[i]);
        if corners.is_none() || corners != key(&refs[kept - 1]).0 {
            refs.swap(kept, i);
            kept += 1;
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Aabb, Vec3, hash};

    #[test]
    fn boxes_lie_in_the_order_of_the_leaves_and_none_is_lost() {
        let center = |i: u32| {
            Vec3::from(
                hash::pcg4d([i, 1, 2, 3])
                    .map(hash::unit_f32)
                    .first_chunk()
                    .copied()
                    .expect("four"),
            )
        };
        let around = |i: u32| Aabb {
            min: center(i),
            max: center(i) + 0.01,
        };
        let geometry = Geometry::default();
        let context = PartitionContext {
            geometry: &geometry,
            mobility: Mobility::Moving,
            scale: 1.0,
        };
        for (count, same) in [(1, false), (2, false), (1000, false), (1000, true)] {
            let mut refs: Vec<PrimBox> = (0..count)
                .map(|i| PrimBox::new(&around(if same { 0 } else { i }), i))
                .collect();
            let partition = Partition::new(Set { refs: &mut refs, same }, &context);
            let (mut next, mut inner, mut open) = (0, 1, vec![0]);
            while let Some(at) = open.pop() {
                let node = &partition.nodes[at];
                let first = node.first_index as usize;
                if node.is_leaf() {
                    assert_eq!((first, partition.sizes[at]), (next, 1));
                    next += 1;
                } else {
                    assert_eq!(
                        (first, partition.sizes[at]),
                        (inner, partition.sizes[first] + partition.sizes[first + 1])
                    );
                    inner += 2;
                    open.extend([first + 1, first]);
                }
            }
            assert_eq!((next, partition.sizes[0]), (count as usize, count));
            let mut left: Vec<u32> = partition.refs.iter().map(PrimBox::index).collect();
            left.sort_unstable();
            assert!(left.into_iter().eq(0..count));
        }
    }
}
