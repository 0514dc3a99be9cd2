//! Comparison of entry nodes with the rays that start at them.

use super::*;
use crate::{
    accel::{kernels::tree::IdSpace, wide::node::inner},
    geometry::padding::BoundsPadding,
    math::{Aabb, Vec3, hash},
    simd::portable::Portable,
};

/// For scenes with an extent of 1.
const UNIT: BoundsPadding = BoundsPadding {
    reach: 1.0,
    origin: 0.0,
};

fn unit(i: u32, k: u32) -> f32 {
    hash::unit_f32(hash::pcg4d([i, k, 5, 7])[0])
}

#[test]
fn every_ray_begins_once() {
    let mut tree = WideTree::default();
    tree.push((vec![WideNode::NOTHING], vec![]), IdSpace::prims(0))
        .expect("a tree");
    let mut entry_points = EntryPoints::new();
    for count in [1, 16, 100, 255, 256, 257, 5000] {
        let rays = vec![Ray::NONE; count];
        let list: Vec<u32> = (0..count as u32).rev().collect();
        entry_points.begin(&tree);
        let begun: Vec<u32> = (0..count)
            .map(|at| {
                let next = entry_points.next(Portable, &tree, &rays, &list, at).or_else(|| {
                    entry_points.passed();
                    entry_points.next(Portable, &tree, &rays, &list, at)
                });
                next.expect("nothing is in its way").ray as u32
            })
            .collect();
        assert_eq!(begun, list);
    }
    assert_eq!(entry_points.pays_off(), Some(false));
}

/// Returns whether entry nodes pay off for rays with an extent of 1 in a scene that is a chain of
/// nodes of this `height`.
fn pays(height: f32) -> Option<bool> {
    let bounds = Aabb {
        min: Vec3::new(-1.0, -1.0, -height),
        max: Vec3::new(1.0, 1.0, height),
    };
    let mut nodes = vec![WideNode::NOTHING; MAX_OPENED + 2];
    for (i, node) in nodes[..=MAX_OPENED].iter_mut().enumerate() {
        node.set(0, &bounds, inner(i + 1));
    }
    let mut tree = WideTree::default();
    tree.push((nodes, vec![]), IdSpace::prims(0)).expect("a tree");
    tree.padding = UNIT;
    let rays: Vec<Ray> = (0..(TRIAL_GROUPS * GROUP) as u32)
        .map(|i| Ray::segment(Vec3::new(-2.0, 0.0, unit(i, 0) - 0.5), Vec3::new(4.0, 0.01, 0.01), 1.0))
        .collect();
    let list: Vec<u32> = (0..rays.len() as u32).collect();
    let mut entry_points = EntryPoints::new();
    entry_points.begin(&tree);
    for at in 0..list.len() {
        entry_points.passed();
        entry_points.next(Portable, &tree, &rays, &list, at);
    }
    entry_points.pays_off()
}

#[test]
fn heads_pay_where_the_rays_of_a_group_come_to_what_is_opened_for_them() {
    assert_eq!(pays(0.6), Some(true));
    // As many nodes are opened, and one ray of fifty visits them.
    assert_eq!(pays(1e-3), Some(false));
}
