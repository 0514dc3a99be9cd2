//! What a ray costs in the wide tree: the same tree, one ray at a time, counting.

use super::{
    super::{Geometry, Hit, PrimRef, RayCost, simd::Tree, slab::Planes},
    node::{EMPTY, LEAF, SHAPE, blocks},
};
use crate::math::Ray;

/// Adds to `cost` what finding the nearest hit of `ray` beyond `best` tests.
pub(super) fn count(tree: &Tree, geometry: &Geometry, mut ray: Ray, mut best: Option<Hit>, cost: &mut RayCost) {
    let planes = Planes::new(&ray, tree.reach);
    if !planes.alive {
        return;
    }
    let octant: u32 = (0..3).map(|axis| u32::from(planes.negative[axis]) << axis).sum();
    let mut open = vec![(0_u32, f32::NEG_INFINITY)];
    while let Some((child, enter)) = open.pop() {
        if enter > ray.tmax || child == EMPTY {
            continue;
        }
        if child & LEAF == 0 {
            let node = &tree.nodes()[child as usize];
            cost.nodes += 1;
            for place in node.order {
                let lane = (place >> (3 * octant) & 7) as usize;
                if let Some(enter) = planes.enter(&node.bounds(lane), ray.tmin, ray.tmax) {
                    open.push((node.child[lane], enter));
                }
            }
            continue;
        }
        let mut test = |index: u32| {
            cost.prims += 1;
            geometry.keep_nearest(PrimRef::new(index), &mut ray, &mut best);
        };
        if child & SHAPE != 0 {
            test(child & !(LEAF | SHAPE));
        } else {
            let ids = tree.blocks()[blocks(child)].iter().flat_map(|block| block.ids);
            ids.filter(|&id| id != u32::MAX).for_each(|id| test(id - 1));
        }
    }
}
