//! The wide tree, built in parallel.
//!
//! The binary tree is cut into some dozen pieces, the largest boxes first. Each piece is brought into depth-first
//! order and collapsed by itself, with arrays and numbers of its own; what is above the cuts is collapsed last, with
//! the pieces as its leaves. Then all are copied behind one another. A cut is always a child of a wide node, which costs
//! nothing that can be measured as long as pieces are large.

use std::collections::{BinaryHeap, HashMap};

use obvhs::bvh2::Bvh2;
use rayon::prelude::*;

use super::{
    super::{
        Geometry,
        binary::{flatten, flatten_to},
        prims::Prims,
        simd::pages,
    },
    collapse::{PIECE, Piece, collapse},
    node::{Block, EMPTY, LEAF, Node, SHAPE},
};
use crate::math::Aabb;

/// Pieces for each thread, so that none waits long for another's last one.
const PIECES_PER_THREAD: usize = 16;

/// Fewer primitives are not worth a cut.
const MIN_PRIMS: usize = 8192;

/// The nodes and blocks of the wide tree over `tree`; the first node is the root.
pub(super) fn build(tree: &Bvh2, prims: &Prims, geometry: &Geometry) -> (Vec<Node>, Vec<Block>) {
    let most = PIECES_PER_THREAD * rayon::current_num_threads();
    let cuts = cut(tree, (prims.ids.len() / MIN_PRIMS).clamp(1, most));
    let mut pieces: Vec<(Piece, Aabb)> = cuts
        .par_iter()
        .with_max_len(1)
        .map(|&root| {
            let flat = flatten(tree, root, &prims.boxes);
            let no_pieces = |_| f32::INFINITY;
            (collapse(&flat, prims, geometry, no_pieces), flat[0].bounds)
        })
        .collect();
    if let [(whole, _)] = &mut pieces[..]
        && !whole.nodes.is_empty()
    {
        return (std::mem::take(&mut whole.nodes), std::mem::take(&mut whole.blocks));
    }
    let numbers: HashMap<u32, u32> = cuts.iter().copied().zip(0..).collect();
    let flat = flatten_to(tree, 0, |index| {
        numbers
            .get(&index)
            .map(|&number| (PIECE | number, pieces[number as usize].1))
    });
    let top = if flat[0].is_leaf() {
        let mut root = Node::NOTHING;
        root.set(0, &flat[0].bounds, EMPTY);
        Piece {
            nodes: vec![root],
            joints: vec![(0, 0, 0)],
            ..Piece::default()
        }
    } else {
        collapse(&flat, prims, geometry, |number| pieces[number as usize].0.cost)
    };
    join(top, pieces.into_iter().map(|(piece, _)| piece).collect())
}

/// Nodes that together hold every leaf, at most `count` of them.
fn cut(tree: &Bvh2, count: usize) -> Vec<u32> {
    let entry = |index: u32| (tree.nodes[index as usize].aabb().half_area().to_bits(), index);
    let mut open = BinaryHeap::from([entry(0)]);
    let mut cuts = Vec::new();
    while open.len() + cuts.len() < count
        && let Some((_, index)) = open.pop()
    {
        let node = &tree.nodes[index as usize];
        if node.is_leaf() {
            cuts.push(index);
        } else {
            open.extend([entry(node.first_index), entry(node.first_index + 1)]);
        }
    }
    cuts.extend(open.into_iter().map(|(_, index)| index));
    cuts
}

/// Puts all pieces behind one another and corrects their numbers.
fn join(mut top: Piece, pieces: Vec<Piece>) -> (Vec<Node>, Vec<Block>) {
    let starts: Vec<(usize, usize)> = pieces
        .iter()
        .scan((top.nodes.len(), 0), |next, piece| {
            let start = *next;
            *next = (start.0 + piece.nodes.len(), start.1 + piece.blocks.len());
            Some(start)
        })
        .collect();
    for &(node, lane, number) in &top.joints {
        let number = number as usize;
        top.nodes[node as usize].child[usize::from(lane)] = moved(pieces[number].root, starts[number]);
    }
    let node_count = top.nodes.len() + pieces.iter().map(|piece| piece.nodes.len()).sum::<usize>();
    let block_count = pieces.iter().map(|piece| piece.blocks.len()).sum();
    let mut nodes = pages::reserve(node_count);
    nodes.extend_from_slice(&top.nodes);
    nodes.par_extend(
        (top.nodes.len()..node_count)
            .into_par_iter()
            .with_min_len(1024)
            .map(|i| {
                let piece = starts.partition_point(|start| start.0 <= i) - 1;
                let node = pieces[piece].nodes[i - starts[piece].0];
                Node {
                    child: node.child.map(|child| moved(child, starts[piece])),
                    ..node
                }
            }),
    );
    let mut blocks = pages::reserve(block_count);
    blocks.par_extend((0..block_count).into_par_iter().with_min_len(1024).map(|i| {
        let piece = starts.partition_point(|start| start.1 <= i) - 1;
        pieces[piece].blocks[i - starts[piece].1]
    }));
    (nodes, blocks)
}

/// A child's number after its piece's nodes and blocks were moved to `start`.
fn moved(child: u32, (nodes, blocks): (usize, usize)) -> u32 {
    if child & LEAF == 0 {
        child + nodes as u32
    } else if child & SHAPE == 0 {
        child + ((blocks as u32) << 2)
    } else {
        child
    }
}
