//! Collapsing a binary tree over lights into nodes of up to eight groups.

use super::{
    LightTree,
    binary::BinaryNode,
    groups::WIDTH,
    node::{Child, LightNode, Place},
};
use crate::{light::LightBounds, math::Vec3};

/// Collapses the binary tree `nodes`, whose leaves hold `lights` from left to right.
pub(super) fn collapse(nodes: &[BinaryNode], lights: &[u32], tree: &mut LightTree) {
    let Some(root) = nodes.first() else { return };
    tree.all.set(0, &root.bounds);
    tree.nodes.push(LightNode::new(None));
    // Nodes to fill, with the root of each in the binary tree and the leaves before it.
    let mut waiting = vec![(0, 0, 0)];
    while let Some((node, root, leaf)) = waiting.pop() {
        let mut opened = vec![(root, leaf)];
        while opened.len() < WIDTH
            && let Some(widest) = widest(nodes, &opened)
        {
            let (at, leaf) = opened[widest];
            let left = at + 1;
            let left_leaves = nodes[left].leaves;
            opened[widest] = (left, leaf);
            opened.insert(widest + 1, (at + 2 * left_leaves as usize, leaf + left_leaves));
        }
        for (lane, (at, leaf)) in opened.into_iter().enumerate() {
            let place = Place {
                node,
                lane: lane as u32,
            };
            let child = if nodes[at].leaves == 1 {
                let light = lights[leaf as usize];
                tree.places[light as usize] = Some(place);
                Child::Light(light)
            } else {
                let below = tree.nodes.len() as u32;
                tree.nodes.push(LightNode::new(Some(place)));
                waiting.push((below, at, leaf));
                Child::Node(below)
            };
            let filled = &mut tree.nodes[node as usize];
            filled.groups.set(lane, &nodes[at].bounds);
            filled.set_child(lane, child);
        }
    }
}

/// The group to open next: the one with the largest power and extent.
fn widest(nodes: &[BinaryNode], opened: &[(usize, u32)]) -> Option<usize> {
    let extent = |group: &LightBounds| (group.bounds.max - group.bounds.min).max(Vec3::splat(f32::MIN_POSITIVE));
    let weight = |at: usize| {
        let group = &nodes[at].bounds;
        f64::from(group.power) * f64::from(extent(group).max_element()).powi(2)
    };
    let groups = opened.iter().enumerate().filter(|(_, (at, _))| nodes[*at].leaves > 1);
    let widest = groups.max_by(|(i, (a, _)), (j, (b, _))| weight(*a).total_cmp(&weight(*b)).then(j.cmp(i)));
    widest.map(|(i, _)| i)
}
