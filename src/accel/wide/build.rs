//! The wide tree, built in parallel.
//!
//! Each piece of the binary tree is collapsed by itself, with arrays and numbers of its own; what is above the pieces is
//! collapsed last, with the pieces among its leaves. Then all are copied behind one another. A piece is always a child of
//! a wide node, which costs nothing that can be measured as pieces are large.

use rayon::prelude::*;

use super::{
    super::{
        Geometry, Quality,
        binary::{self, Forest, Leaves, Tree},
        prims::Prims,
        simd::pages,
    },
    collapse::{Piece, collapse, order_children},
    node::{self, Block, EMPTY, Node},
};

/// The most triangles of a leaf of the binary tree. With four of them, a block, there is less to plan; with two the
/// plan is better by some percent.
fn leaves(quality: Quality) -> Leaves {
    Leaves {
        triangles: if quality == Quality::Fast { 4 } else { 2 },
    }
}

/// The nodes and blocks of the wide tree over `prims`; the first node is the root. `None` where there are none.
pub(super) fn build(prims: Prims, geometry: &Geometry, quality: Quality) -> Option<(Vec<Node>, Vec<Block>)> {
    let finish = |tree: Tree| {
        let no_pieces = |_| [f32::INFINITY; 2];
        collapse(&tree, geometry, no_pieces)
    };
    let Forest { top, mut pieces } = binary::build(prims, geometry, quality, leaves(quality), finish)?;
    if let [whole] = &mut pieces[..]
        && !whole.nodes.is_empty()
    {
        return Some((std::mem::take(&mut whole.nodes), std::mem::take(&mut whole.blocks)));
    }
    let top = if let [only] = top.nodes[..] {
        let mut root = Node::NOTHING;
        root.set(0, &only.bounds, EMPTY);
        order_children(&mut root, 1);
        Piece {
            nodes: vec![root],
            joints: vec![(0, 0, 0)],
            ..Piece::default()
        }
    } else {
        collapse(&top, geometry, |number| {
            [pieces[number as usize].cost, pieces[number as usize].surface]
        })
    };
    Some(join(top, pieces))
}

/// Puts all pieces behind one another and corrects their numbers.
fn join(mut top: Piece, pieces: Vec<Piece>) -> (Vec<Node>, Vec<Block>) {
    let starts: Vec<(usize, usize)> = pieces
        .iter()
        .scan((top.nodes.len(), top.blocks.len()), |next, piece| {
            let start = *next;
            *next = (start.0 + piece.nodes.len(), start.1 + piece.blocks.len());
            Some(start)
        })
        .collect();
    let moved = |child: u32, (nodes, blocks): (usize, usize)| node::moved(child, nodes as isize, blocks as isize);
    for &(node, lane, number) in &top.joints {
        let number = number as usize;
        top.nodes[node as usize].child[usize::from(lane)] = moved(pieces[number].root, starts[number]);
    }
    let node_count = top.nodes.len() + pieces.iter().map(|piece| piece.nodes.len()).sum::<usize>();
    let block_count = top.blocks.len() + pieces.iter().map(|piece| piece.blocks.len()).sum::<usize>();
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
    blocks.extend_from_slice(&top.blocks);
    blocks.par_extend(
        (top.blocks.len()..block_count)
            .into_par_iter()
            .with_min_len(1024)
            .map(|i| {
                let piece = starts.partition_point(|start| start.1 <= i) - 1;
                pieces[piece].blocks[i - starts[piece].1]
            }),
    );
    (nodes, blocks)
}
