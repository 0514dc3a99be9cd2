//! The binary tree that the others are made of, built by obvhs: PLOC, then reinsertion.
//!
//! obvhs sees *proxies*, not the primitives' boxes. PLOC merges two nodes when each is the other's cheapest partner;
//! where many pairs cost the same (identical boxes, a regular grid, boxes without area in a line) hardly any choice is
//! mutual and the time grows with the square of the count: 8,000 identical triangles take 1.4 s, 100,000 never end.
//! So a proxy is its primitive's box scaled with the scene to unit size, given some thickness, and moved by a tiny part
//! of its size ([`JITTER`]) in a direction of its own. That leaves no ties. The true boxes take the proxies' place
//! afterwards.
//!
//! Source: Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction", 2018,
//! <https://doi.org/10.1109/TVCG.2017.2669983>, and "Parallel Reinsertion for Bounding Volume Hierarchy Optimization",
//! 2018, <https://doi.org/10.1111/cgf.13350>.

use glam::Vec3A;
use obvhs::{
    aabb::Aabb as Box3,
    bvh2::{Bvh2, DEFAULT_MAX_STACK_DEPTH, reinsertion::ReinsertionOptimizer},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
};
use rayon::prelude::*;

use super::{Quality, prims::Prims};
use crate::math::{Aabb, hash};

/// How far a proxy is moved and how thick it is at least, relative to its box's longest side.
const JITTER: f32 = 1.0 / 65_536.0;

/// The same for boxes that are hardly larger than the spacing of the numbers they are made of.
const JITTER_ULPS: f32 = 2.0 * f32::EPSILON;

/// A length, in units of the scene's size, whose square is still a normal number.
const SMALLEST: f32 = 1.0 / (1_u64 << 55) as f32;

/// The tree over `prims`; a leaf holds one of them. `None` where there are none.
pub(super) fn build(prims: &Prims, quality: Quality) -> Option<Bvh2> {
    if prims.boxes.is_empty() {
        return None;
    }
    let scale = 1.0 / prims.reach.max(f32::MIN_POSITIVE);
    let proxies: Vec<Box3> = prims
        .boxes
        .par_iter()
        .enumerate()
        .with_min_len(4096)
        .map(|(i, bounds)| proxy(bounds, scale, i as u32))
        .collect();
    let (distance, threshold, reinsertion) = match quality {
        Quality::Fast => (PlocSearchDistance::Low, 2, 0.01),
        Quality::Medium => (PlocSearchDistance::Medium, 3, 0.05),
        Quality::High => (PlocSearchDistance::High, 1, 0.5),
    };
    let indices = (0..proxies.len() as u32).collect();
    let mut tree =
        PlocBuilder::with_capacity(proxies.len()).build(distance, &proxies, indices, SortPrecision::U64, threshold);
    // Its stack on the heap panics when it is full; the fixed one, which this asks for, only forgoes a candidate.
    tree.max_depth = DEFAULT_MAX_STACK_DEPTH;
    ReinsertionOptimizer::default().run(&mut tree, reinsertion, None);
    Some(tree)
}

fn proxy(bounds: &Aabb, scale: f32, number: u32) -> Box3 {
    let (min, max) = (Vec3A::from(bounds.min) * scale, Vec3A::from(bounds.max) * scale);
    let extent = (max - min).max_element();
    let magnitude = min.abs().max(max.abs()).max_element();
    let step = (extent * JITTER).max(magnitude * JITTER_ULPS).max(SMALLEST);
    let [x, y, z, _] = hash::pcg4d([number, 0, 0, 0]).map(hash::unit_f32);
    let shift = (Vec3A::new(x, y, z) - 0.5) * step;
    Box3::new(min + shift, (max + shift).max(min + shift + step))
}

/// A node of a tree in depth-first order: a node's first child follows it, and all children come after their parents.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flat {
    /// The box around everything below, from the primitives' own boxes.
    pub bounds: Aabb,
    /// The second child's index.
    pub second: u32,
    /// What a leaf holds, for a primitive its index into [`Prims::ids`]; [`Flat::INNER`] for a node with children.
    pub leaf: u32,
}

impl Flat {
    pub const INNER: u32 = u32::MAX;

    pub fn is_leaf(&self) -> bool {
        self.leaf != Self::INNER
    }
}

/// The nodes below `root` in depth-first order, down to the primitives.
pub(super) fn flatten(tree: &Bvh2, root: u32, boxes: &[Aabb]) -> Vec<Flat> {
    flatten_to(tree, root, |index| {
        let node = &tree.nodes[index as usize];
        node.is_leaf().then(|| {
            let prim = tree.primitive_indices[node.first_index as usize];
            (prim, boxes[prim as usize])
        })
    })
}

/// The nodes below `root` in depth-first order, down to those for which `leaf` knows what they hold and their box.
pub(super) fn flatten_to(tree: &Bvh2, root: u32, leaf: impl Fn(u32) -> Option<(u32, Aabb)>) -> Vec<Flat> {
    const NOBODY: u32 = u32::MAX;
    let mut flat: Vec<Flat> = Vec::new();
    let mut open = vec![(root, NOBODY)];
    while let Some((index, parent)) = open.pop() {
        let at = flat.len() as u32;
        if parent != NOBODY {
            flat[parent as usize].second = at;
        }
        let (leaf, bounds) = leaf(index).unwrap_or_else(|| {
            let first = tree.nodes[index as usize].first_index;
            open.push((first + 1, at));
            open.push((first, NOBODY));
            (Flat::INNER, Aabb::EMPTY)
        });
        flat.push(Flat {
            bounds,
            second: 0,
            leaf,
        });
    }
    for i in (0..flat.len()).rev() {
        if !flat[i].is_leaf() {
            flat[i].bounds = flat[i + 1].bounds.union(flat[flat[i].second as usize].bounds);
        }
    }
    flat
}

/// Gives every node of `tree` its true box in place of the proxies'.
pub(super) fn refit(tree: &mut Bvh2, boxes: &[Aabb]) {
    let mut order = Vec::with_capacity(tree.nodes.len());
    let mut open = vec![0_u32];
    while let Some(index) = open.pop() {
        order.push(index);
        let node = &tree.nodes[index as usize];
        if !node.is_leaf() {
            open.extend([node.first_index, node.first_index + 1]);
        }
    }
    for index in order.into_iter().rev() {
        let node = tree.nodes[index as usize];
        let first = node.first_index as usize;
        let bounds = if node.is_leaf() {
            let b = boxes[tree.primitive_indices[first] as usize];
            Box3::new(b.min.into(), b.max.into())
        } else {
            tree.nodes[first].aabb().union(tree.nodes[first + 1].aabb())
        };
        tree.nodes[index as usize].set_aabb(bounds);
    }
}
