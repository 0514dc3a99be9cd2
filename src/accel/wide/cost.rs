//! The cost of a ray: a scalar traversal of the wide tree that counts its tests.

use super::node::{self, EMPTY, INSTANCE, LEAF, SHAPE, blocks};
use crate::{
    accel::{accelerator::RayCost, kernels::tree::WideTree},
    geometry::{Geometry, Hit, InstanceId, PrimId, padding::BoundsPadding, slab::Planes},
    math::Ray,
};

/// A ray in the space of a tree.
struct InstanceState<'a> {
    tree: &'a WideTree,
    geometry: &'a Geometry,
    root: u32,
    instance: InstanceId,
    padding: BoundsPadding,
}

/// Adds to `cost` the tests that finding the nearest hit of `ray` before `best` takes.
pub(super) fn count(tree: &WideTree, geometry: &Geometry, mut ray: Ray, mut best: Option<Hit>, cost: &mut RayCost) {
    if tree.nodes().is_empty() {
        return;
    }
    let world = InstanceState {
        tree,
        geometry,
        root: tree.root(),
        instance: InstanceId::NONE,
        padding: tree.padding,
    };
    world.count(&mut ray, &mut best, cost);
}

impl InstanceState<'_> {
    fn count(&self, ray: &mut Ray, best: &mut Option<Hit>, cost: &mut RayCost) {
        let planes = Planes::new(ray, self.padding);
        if !planes.can_hit {
            return;
        }
        let octant: u32 = (0..3).map(|axis| u32::from(planes.negative[axis]) << axis).sum();
        let mut open = vec![(self.root, f32::NEG_INFINITY)];
        while let Some((child, enter)) = open.pop() {
            if enter > ray.tmax || child == EMPTY {
                continue;
            }
            if child & LEAF == 0 {
                let node = &self.tree.nodes()[node::index(child)];
                cost.nodes += 1;
                for place in node.order.into_iter().rev() {
                    let lane = (place >> (3 * octant) & 7) as usize;
                    if let Some(enter) = planes.enter(&node.bounds(lane), ray.tmin, ray.tmax) {
                        open.push((node.child[lane], enter));
                    }
                }
                continue;
            }
            if child & SHAPE != 0 && child & INSTANCE != 0 {
                let instance = InstanceId(node::number(child));
                let placed = &self.geometry.instances[instance.0 as usize];
                let mut local = self.geometry.enter(placed, ray);
                let group = Self {
                    root: self.tree.group_root(placed.group),
                    instance,
                    padding: self.padding.inside(),
                    ..*self
                };
                group.count(&mut local, best, cost);
                ray.tmax = local.tmax;
                continue;
            }
            let mut test = |prim: PrimId| {
                cost.prims += 1;
                self.geometry.keep_nearest(prim, self.instance, ray, best);
            };
            if child & SHAPE != 0 {
                test(PrimId::new(node::number(child)));
            } else {
                let keys = self.tree.blocks()[blocks(child)].iter().flat_map(|block| block.keys);
                keys.filter_map(PrimId::of_key).for_each(test);
            }
        }
    }
}
