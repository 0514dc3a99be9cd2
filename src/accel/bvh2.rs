//! A binary BVH with a scalar traversal: simple, and a reference for the speed of the others.

use super::{
    accelerator::Quality,
    build::{
        self,
        bvh2_tree::{self, Leaves},
        prims::Prims,
    },
    two_level::{self, BoxTree},
};
use crate::{
    geometry::{Geometry, slab::Planes},
    math::Ray,
};
use std::ops::ControlFlow;

/// The accelerator.
pub(super) type Bvh2 = two_level::TwoLevel<Binary>;

/// A binary tree over boxes.
#[derive(Default)]
pub(super) struct Binary(bvh2_tree::Bvh2Tree);

impl BoxTree for Binary {
    type Stack = Vec<(u32, f32)>;

    fn build(prims: Prims, geometry: &Geometry, quality: Quality) -> Self {
        let leaves = Leaves { triangles: 4 };
        Self(build::build_tree(prims, geometry, quality, leaves).unwrap_or_default())
    }

    /// Visits the nearer child first.
    fn walk(
        &self,
        ray: &mut Ray,
        planes: &Planes,
        stack: &mut Self::Stack,
        nodes: &mut u32,
        mut leaf: impl FnMut(u32, &mut Ray) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        stack.clear();
        let Some(root) = self.0.nodes.first() else {
            return ControlFlow::Continue(());
        };
        *nodes += 1;
        if let Some(t) = planes.enter(&root.bounds, ray.tmin, ray.tmax) {
            stack.push((0, t));
        }
        while let Some((index, t)) = stack.pop() {
            if t > ray.tmax {
                continue;
            }
            let node = &self.0.nodes[index as usize];
            if node.is_leaf() {
                let (first, count) = (node.link as usize, node.count as usize);
                for &id in &self.0.ids[first..first + count] {
                    leaf(id, ray)?;
                }
                continue;
            }
            *nodes += 2;
            let children = [index + 1, node.link];
            let enter = children.map(|c| planes.enter(&self.0.nodes[c as usize].bounds, ray.tmin, ray.tmax));
            match enter {
                [Some(a), Some(b)] if a <= b => stack.extend([(children[1], b), (children[0], a)]),
                [Some(a), Some(b)] => stack.extend([(children[0], a), (children[1], b)]),
                [Some(a), None] => stack.push((children[0], a)),
                [None, Some(b)] => stack.push((children[1], b)),
                [None, None] => {}
            }
        }
        ControlFlow::Continue(())
    }

    fn node_count(&self) -> usize {
        self.0.nodes.len()
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.0.nodes[..]) + size_of_val(&self.0.ids[..])
    }
}
