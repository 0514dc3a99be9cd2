//! A binary tree, traversed one ray at a time in plain Rust: simple enough to trust, and a yardstick.

use super::{
    Geometry, Quality,
    binary::{self, Flat},
    levels::{self, Tree, Walk},
    prims::Prims,
    slab::Planes,
};
use crate::math::Ray;

/// The accelerator.
pub(super) type Bvh2 = levels::Levels<Binary>;

/// A binary tree over boxes, one item a leaf.
#[derive(Default)]
pub(super) struct Binary {
    nodes: Vec<Flat>,
    ids: Vec<u32>,
}

impl Tree for Binary {
    type Stack = Vec<(u32, f32)>;

    fn build(prims: Prims, _geometry: &Geometry, quality: Quality) -> Self {
        let tree = binary::build(&prims, quality);
        Self {
            nodes: tree.map_or_else(Vec::new, |tree| binary::flatten(&tree, 0, &prims.boxes)),
            ids: prims.ids,
        }
    }

    /// Nearer boxes come first.
    fn walk(
        &self,
        ray: &mut Ray,
        planes: &Planes,
        stack: &mut Self::Stack,
        nodes: &mut u32,
        mut leaf: impl FnMut(u32, &mut Ray) -> Walk,
    ) -> Walk {
        stack.clear();
        let Some(root) = self.nodes.first() else {
            return Walk::GoOn;
        };
        *nodes += 1;
        if let Some(t) = planes.enter(&root.bounds, ray.tmin, ray.tmax) {
            stack.push((0, t));
        }
        while let Some((index, t)) = stack.pop() {
            if t > ray.tmax {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.is_leaf() {
                match leaf(self.ids[node.leaf as usize], ray) {
                    Walk::GoOn => continue,
                    Walk::Stop => return Walk::Stop,
                }
            }
            *nodes += 2;
            let children = [index + 1, node.second];
            let enter = children.map(|c| planes.enter(&self.nodes[c as usize].bounds, ray.tmin, ray.tmax));
            match enter {
                [Some(a), Some(b)] if a <= b => stack.extend([(children[1], b), (children[0], a)]),
                [Some(a), Some(b)] => stack.extend([(children[0], a), (children[1], b)]),
                [Some(a), None] => stack.push((children[0], a)),
                [None, Some(b)] => stack.push((children[1], b)),
                [None, None] => {}
            }
        }
        Walk::GoOn
    }

    fn node_count(&self) -> usize {
        self.nodes.len()
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.ids[..])
    }
}
