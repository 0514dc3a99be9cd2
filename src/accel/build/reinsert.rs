//! Reinsertion of all nodes of a tree, on all threads.
//!
//! obvhs's own passes run on one thread, which suits the many partitions. Here, the best position
//! of every node is searched in parallel, in the tree as it is before the pass. Then nodes are
//! moved one after another, those with the largest gain first, unless they conflict with an earlier
//! one. The result does not depend on the number of threads. obvhs's feature `parallel` does not
//! guarantee this, since it leaves the order of equal gains to the threads.
//!
//! Source: Meister and Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization",
//! 2018, <https://doi.org/10.1111/cgf.13350>.

use obvhs::bvh2::{
    Bvh2,
    node::Bvh2Node,
    reinsertion::{Reinsertion, find_reinsertion, reinsert_node},
};
use rayon::prelude::*;

/// The smallest number of searches that is worth another thread.
const PAR_MIN_LEN: usize = 64;

/// Reinserts every node at its best position, in this number of passes.
pub fn reinsert_all(tree: &mut Bvh2, passes: usize) {
    tree.init_parents_if_uninit();
    tree.children_are_ordered_after_parents = false;
    let count = tree.nodes.len();
    let mut touched = vec![false; count];
    for _ in 0..passes {
        // The root is not moved.
        let mut moves: Vec<Reinsertion> = (1..count)
            .into_par_iter()
            .with_min_len(PAR_MIN_LEN)
            .map(|node| find_reinsertion(tree, node))
            .filter(|found| found.area_diff > 0.0)
            .collect();
        moves.sort_unstable_by(|a, b| b.area_diff.total_cmp(&a.area_diff).then(a.from.cmp(&b.from)));
        touched.fill(false);
        for Reinsertion { from, to, .. } in moves {
            let [from, to] = [from, to].map(|node| node as usize);
            let parent = |node: usize| tree.parents[node] as usize;
            let changed = [from, Bvh2Node::get_sibling_id(from), parent(from), to, parent(to)];
            if changed.iter().any(|&node| touched[node]) {
                continue;
            }
            changed.iter().for_each(|&node| touched[node] = true);
            reinsert_node(tree, from, to);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;
    use obvhs::aabb::Aabb as Box3;

    use super::*;
    use crate::math::hash;

    /// Returns a chain: each node has one of the boxes, which are in no order, and all others below
    /// it.
    fn chain(count: u32) -> Bvh2 {
        let mut nodes = vec![Bvh2Node::new(Box3::INVALID, 0, 1)];
        for i in 0..count {
            let [x, y, z, _] = hash::pcg4d([i, 1, 2, 3]).map(hash::unit_f32);
            let at = Vec3A::new(x, y, z);
            let leaf = Bvh2Node::new(Box3::new(at, at + 0.01), 1, i);
            if i + 1 == count {
                *nodes.last_mut().expect("there is a root") = leaf;
            } else {
                let next = nodes.len() as u32;
                nodes.last_mut().expect("there is a root").make_inner(next);
                nodes.extend([leaf, Bvh2Node::new(Box3::INVALID, 0, 0)]);
            }
        }
        for i in (0..nodes.len()).rev().filter(|i| i % 2 == 0) {
            if !nodes[i].is_leaf() {
                let first = nodes[i].first_index as usize;
                let around = nodes[first].aabb().union(nodes[first + 1].aabb());
                nodes[i].set_aabb(around);
            }
        }
        Bvh2 {
            nodes,
            primitive_indices: (0..count).collect(),
            ..Bvh2::default()
        }
    }

    fn surface(tree: &Bvh2) -> f32 {
        tree.nodes.iter().map(|node| node.aabb().half_area()).sum()
    }

    #[test]
    fn every_leaf_stays_and_what_is_around_all_shrinks() {
        let reinserted = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let mut tree = chain(1000);
            pool.expect("threads").install(|| reinsert_all(&mut tree, 8));
            tree
        };
        let [one, three] = [1, 3].map(reinserted);
        assert!(surface(&one) < 0.2 * surface(&chain(1000)), "{}", surface(&one));
        let mut leaves = Vec::new();
        let mut open = vec![0];
        while let Some(at) = open.pop() {
            let node = &one.nodes[at];
            let twin = &three.nodes[at];
            assert_eq!((node.prim_count, node.first_index), (twin.prim_count, twin.first_index));
            if node.is_leaf() {
                leaves.push(node.first_index);
                continue;
            }
            let first = node.first_index as usize;
            let around = one.nodes[first].aabb().union(one.nodes[first + 1].aabb());
            assert_eq!((node.aabb().min, node.aabb().max), (around.min, around.max));
            open.extend([first, first + 1]);
        }
        leaves.sort_unstable();
        assert!(leaves.into_iter().eq(0..1000));
    }
}
