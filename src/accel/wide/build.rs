//! Parallel construction of the wide tree.
//!
//! Each piece of the binary tree is collapsed on its own, with its own arrays and indices. The tree
//! above the pieces is collapsed last, with the pieces among its leaves. Then all arrays are
//! concatenated. A piece is always a child of a wide node; since pieces are large, this restriction
//! has no measurable cost.

use rayon::prelude::*;

use super::{
    collapse::{TreePiece, collapse, order_children},
    node::{self, EMPTY, TriangleBlock, WideNode},
};
use crate::{
    accel::build::{
        self,
        bvh2_tree::{Bvh2Tree, Forest, Leaves},
        prims::Prims,
    },
    geometry::Geometry,
    simd::huge_pages,
};

/// The leaf size of the binary tree. With four triangles (one block), collapsing is faster; with
/// two, the collapsed tree is better by some percent.
const LEAVES: Leaves = Leaves { triangles: 2 };

/// Builds the nodes and triangle blocks of the wide tree over `prims`; node 0 is the root. Returns
/// `None` if there are no primitives.
pub(super) fn build(prims: Prims, geometry: &Geometry) -> Option<(Vec<WideNode>, Vec<TriangleBlock>)> {
    let finish = |tree: Bvh2Tree| {
        let no_pieces = |_| [f32::INFINITY; 2];
        collapse(&tree, geometry, no_pieces)
    };
    let Forest { top, mut pieces } = build::build_forest(prims, geometry, LEAVES, finish)?;
    if let [whole] = &mut pieces[..]
        && !whole.nodes.is_empty()
    {
        return Some((std::mem::take(&mut whole.nodes), std::mem::take(&mut whole.blocks)));
    }
    let top = if let [only] = top.nodes[..] {
        let mut root = WideNode::NOTHING;
        root.set(0, &only.bounds, EMPTY);
        order_children(&mut root, 1);
        TreePiece {
            nodes: vec![root],
            joints: vec![(0, 0, 0)],
            ..TreePiece::default()
        }
    } else {
        collapse(&top, geometry, |number| {
            [pieces[number as usize].cost, pieces[number as usize].surface]
        })
    };
    Some(join(top, pieces))
}

/// Concatenates all pieces and corrects their indices.
fn join(mut top: TreePiece, pieces: Vec<TreePiece>) -> (Vec<WideNode>, Vec<TriangleBlock>) {
    let nodes: Vec<&[WideNode]> = pieces.iter().map(|piece| &piece.nodes[..]).collect();
    let blocks: Vec<&[TriangleBlock]> = pieces.iter().map(|piece| &piece.blocks[..]).collect();
    let (node_starts, block_starts) = (starts(top.nodes.len(), &nodes), starts(top.blocks.len(), &blocks));
    let moved =
        |child: u32, piece: usize| node::moved(child, node_starts[piece] as isize, block_starts[piece] as isize);
    for &(node, lane, number) in &top.joints {
        let number = number as usize;
        top.nodes[node as usize].child[usize::from(lane)] = moved(pieces[number].root, number);
    }
    let nodes = behind(&top.nodes, &nodes, &node_starts, |node: &WideNode, piece| WideNode {
        child: node.child.map(|child| moved(child, piece)),
        ..*node
    });
    let blocks = behind(&top.blocks, &blocks, &block_starts, |block: &TriangleBlock, _| *block);
    (nodes, blocks)
}

/// Returns the offset of each of the concatenated `parts`, of which the first starts at `first`,
/// and then the end of the last one.
fn starts<T>(first: usize, parts: &[&[T]]) -> Vec<usize> {
    let mut starts = vec![first];
    starts.extend(parts.iter().scan(first, |next, part| {
        *next += part.len();
        Some(*next)
    }));
    starts
}

/// Concatenates `top` and all parts, each with its elements `moved` to the part's offset.
fn behind<T: Copy + Send + Sync>(
    top: &[T],
    parts: &[&[T]],
    starts: &[usize],
    moved: impl Fn(&T, usize) -> T + Sync,
) -> Vec<T> {
    let count = starts[parts.len()];
    let mut all = huge_pages::reserve(count);
    all.extend_from_slice(top);
    all.par_extend((top.len()..count).into_par_iter().with_min_len(1024).map(|i| {
        let part = starts.partition_point(|&start| start <= i) - 1;
        moved(&parts[part][i - starts[part]], part)
    }));
    all
}
