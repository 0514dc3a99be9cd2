//! New boxes for a tree whose triangles have moved.
//!
//! A node keeps its children, a leaf its triangles. That is much faster than building, and as good as long as
//! triangles stay beside those they were beside. Where they do not, boxes grow and overlap: what a ray is expected to
//! cost, by the surface area heuristic, tells when to build instead.

use super::tree::{Section, WideTree};
use crate::{
    accel::wide::node::{self, EMPTY, LEAF, SHAPE, WideNode, blocks},
    geometry::{Geometry, PrimId},
    math::Aabb,
};

/// A tree that costs so many times what it did when it was built is built anew.
const REFIT_COST_LIMIT: f32 = 1.5;

impl WideTree {
    /// Whether the tree `section`, of primitives alone, now holds the `count` triangles that are to be in it, and well. If
    /// not, it is of no use any more.
    pub fn refit(&mut self, section: usize, geometry: &Geometry, count: usize) -> bool {
        let part = self.sections[section].clone();
        let before = part.cost.unwrap_or_else(|| cost(&self.nodes[part.nodes.clone()]));
        self.sections[section].cost = Some(before);
        // Triangles that were without area are not in the tree; one that has become so may stay.
        if self.set_corners(&part, geometry) < count {
            return false;
        }
        for i in part.nodes.clone().rev() {
            for lane in 0..8 {
                let child = self.nodes[i].child[lane];
                let bounds = if child == EMPTY {
                    continue;
                } else if child & LEAF == 0 {
                    around(&self.nodes[node::index(child)])
                } else if child & SHAPE == 0 {
                    let ids = self.blocks[blocks(child)].iter().flat_map(|block| block.ids);
                    let prims = ids.filter(|&id| id != u32::MAX).map(|id| PrimId::new(id - 1));
                    prims.map(|prim| geometry.bounds(prim)).fold(Aabb::EMPTY, Aabb::union)
                } else {
                    geometry.bounds(PrimId::new(node::number(child)))
                };
                self.nodes[i].set(lane, &bounds, child);
            }
        }
        cost(&self.nodes[part.nodes]) <= before * REFIT_COST_LIMIT
    }

    /// Writes the corners of a tree's triangles; how many triangles there are.
    fn set_corners(&mut self, part: &Section, geometry: &Geometry) -> usize {
        let mut ids: Vec<u32> = Vec::new();
        for block in &mut self.blocks[part.blocks.clone()] {
            for lane in 0..4 {
                let id = block.ids[lane];
                if id != u32::MAX {
                    block.set(lane, geometry.corners(id as usize - 1), id - 1);
                    ids.push(id);
                }
            }
        }
        // One that is split lies in several leaves.
        ids.sort_unstable();
        ids.dedup();
        ids.len()
    }
}

/// The box around a node's children.
fn around(node: &WideNode) -> Aabb {
    let lanes = (0..8).filter(|&lane| node.child[lane] != EMPTY);
    lanes.map(|lane| node.bounds(lane)).fold(Aabb::EMPTY, Aabb::union)
}

/// What a ray that meets the root is expected to cost, in nodes and blocks.
fn cost(nodes: &[WideNode]) -> f32 {
    let area = |bounds: Aabb| {
        if bounds.is_empty() {
            0.0
        } else {
            f64::from(bounds.half_area())
        }
    };
    let Some(root) = nodes.first() else { return 0.0 };
    let leaves = |node: &WideNode| -> f64 {
        let is_leaf = |lane: &usize| node.child[*lane] != EMPTY && node.child[*lane] & (LEAF | SHAPE) == LEAF;
        let cost = |lane| area(node.bounds(lane)) * blocks(node.child[lane]).len() as f64;
        (0..8).filter(is_leaf).map(cost).sum()
    };
    let all: f64 = nodes.iter().map(|node| area(around(node)) + leaves(node)).sum();
    (all / area(around(root)).max(f64::MIN_POSITIVE)) as f32
}
