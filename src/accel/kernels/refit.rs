//! Refitting of a tree whose triangles have moved.
//!
//! Nodes keep their children and leaves their triangles. Refitting is much faster than a rebuild,
//! and the tree is as good if neighbouring triangles stay neighbours. Otherwise boxes grow and
//! overlap. The expected traversal cost, by the surface area heuristic, shows when a rebuild is
//! better.

use super::tree::{Section, WideTree};
use crate::{
    accel::wide::node::{self, EMPTY, LEAF, SHAPE, WideNode, blocks},
    geometry::{Geometry, PrimId},
    math::Aabb,
};

/// The ratio of the current cost to the cost at the build beyond which a tree is rebuilt.
const REFIT_COST_LIMIT: f32 = 1.5;

impl WideTree {
    /// Refits the tree `section`, which has only primitives, to `count` triangles. Returns whether
    /// it holds these triangles and is still good. Otherwise, it must be replaced.
    pub fn refit(&mut self, section: usize, geometry: &Geometry, count: usize) -> bool {
        let part = self.sections[section].clone();
        let before = part.cost.unwrap_or_else(|| cost(&self.nodes[part.nodes.clone()]));
        self.sections[section].cost = Some(before);
        // Triangles that were degenerate at the build are not in the tree. One that has become
        // degenerate may stay.
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
                    let keys = self.blocks[blocks(child)].iter().flat_map(|block| block.keys);
                    keys.filter_map(PrimId::of_key)
                        .map(|prim| geometry.bounds(prim))
                        .fold(Aabb::EMPTY, Aabb::union)
                } else {
                    geometry.bounds(PrimId::new(node::number(child)))
                };
                self.nodes[i].set(lane, &bounds, child);
            }
        }
        cost(&self.nodes[part.nodes]) <= before * REFIT_COST_LIMIT
    }

    /// Writes the vertices of a tree's triangles, and returns the number of triangles.
    fn set_corners(&mut self, part: &Section, geometry: &Geometry) -> usize {
        let mut count = 0;
        for block in &mut self.blocks[part.blocks.clone()] {
            for lane in 0..4 {
                let key = block.keys[lane];
                if let Some(prim) = PrimId::of_key(key) {
                    block.set(lane, geometry.corners(prim.index() as usize), key);
                    count += 1;
                }
            }
        }
        count
    }
}

/// Returns the bounds of a node's children.
fn around(node: &WideNode) -> Aabb {
    let lanes = (0..8).filter(|&lane| node.child[lane] != EMPTY);
    lanes.map(|lane| node.bounds(lane)).fold(Aabb::EMPTY, Aabb::union)
}

/// Returns the expected cost of a ray that hits the root, in nodes and blocks.
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
