//! Heads beside the rays that begin at them.

use super::{
    super::{Numbers, portable::Portable},
    *,
};
use crate::{
    accel::{instance::Spread, wide::node::inner},
    math::{Aabb, Vec3, hash},
};

/// Of scenes that reach 1 far.
const UNIT: Spread = Spread {
    reach: 1.0,
    origin: 0.0,
};

fn unit(i: u32, k: u32) -> f32 {
    hash::unit_f32(hash::pcg4d([i, k, 5, 7])[0])
}

fn vec(i: u32, k: u32) -> Vec3 {
    Vec3::new(unit(i, k), unit(i, k + 1), unit(i, k + 2)) - 0.5
}

/// A node of boxes of many sizes around the origin.
fn node(i: u32) -> Node {
    let mut node = Node::NOTHING;
    for lane in 0..7 {
        let (center, half) = (
            vec(i, 10 * lane),
            vec(i, 10 * lane + 3).abs() * unit(i, 10 * lane + 6).powi(3),
        );
        let bounds = Aabb {
            min: center - half,
            max: center + half,
        };
        node.set(lane as usize, &bounds, lane << 4);
    }
    node
}

#[test]
fn what_any_ray_of_a_group_meets_its_enclosure_meets() {
    let ids: Vec<u32> = (0..GROUP as u32).collect();
    let (mut together, mut met_alone, mut met_together) = (0, 0, 0);
    for i in 0..4000 {
        let (at, to) = (vec(i, 100) * 2.0, vec(i, 103) * 3.0);
        let is_narrow = i % 3 == 0;
        let most = if is_narrow { 1e-3 } else { 0.5 };
        let [apart, wide] = [unit(i, 106), unit(i, 107)].map(|x| most * x * x * x);
        let rays: Vec<Ray> = (0..GROUP as u32)
            .map(|k| {
                let (o, end) = (at + vec(i, 200 + 10 * k) * apart, to + vec(i, 203 + 10 * k) * wide);
                let mut ray = Ray::segment(o, end - o, unit(i, 206 + 10 * k));
                match (i + k) % 200 {
                    0 => ray.tmax = f32::NAN,
                    1 => ray.tmin = f32::NAN,
                    2 => ray.o.x = f32::NAN,
                    3 => ray.d.z = f32::NAN,
                    4 => ray.tmax = f32::INFINITY,
                    5 => ray.tmin = 0.5 * ray.tmax,
                    _ => {}
                }
                ray
            })
            .collect();
        let mut around = Around::default();
        if !around.enclose(Portable, &rays, &ids, UNIT.reach) {
            continue;
        }
        together += 1;
        let node = node(i);
        let (enter, leave) = around.course.cross(Portable, &node, Some(&around.inv_far));
        let met = Portable.met(enter, leave.mul(Portable.splat8(LEAVE))).bits();
        let mut any = 0;
        for ray in &rays {
            let mut slot = Slot::default();
            if slot.start(Portable, ray, 0, UNIT) {
                let (enter, leave) = slot.course.cross(Portable, &node, None);
                any |= Portable.met(enter, leave.mul(Portable.splat8(LEAVE))).bits();
            }
        }
        assert_eq!(any & !met, 0, "group {i}");
        if is_narrow {
            met_alone += any.count_ones();
            met_together += met.count_ones();
        }
    }
    assert!(together > 1000, "{together}");
    // Narrow groups meet hardly anything that none of their rays does.
    assert!(
        met_alone > 50 && met_together < met_alone * 11 / 10,
        "{met_together} {met_alone}"
    );
}

#[test]
fn every_ray_begins_once() {
    let mut tree = Tree::default();
    tree.push((vec![Node::NOTHING], vec![]), Numbers::prims(0))
        .expect("a tree");
    let mut heads = Heads::new();
    for count in [1, 16, 100, 255, 256, 257, 5000] {
        let rays = vec![Ray::NOWHERE; count];
        let list: Vec<u32> = (0..count as u32).rev().collect();
        heads.begin(&tree);
        let begun: Vec<u32> = (0..count)
            .map(|at| {
                let next = heads.next(Portable, &tree, &rays, &list, at).or_else(|| {
                    heads.passed();
                    heads.next(Portable, &tree, &rays, &list, at)
                });
                next.expect("nothing is in its way").ray as u32
            })
            .collect();
        assert_eq!(begun, list);
    }
    assert_eq!(heads.verdict(), Some(false));
}

/// Whether heads pay for rays that are spread out over 1 where a chain of nodes, all that there is, is `height` high.
fn pays(height: f32) -> Option<bool> {
    let bounds = Aabb {
        min: Vec3::new(-1.0, -1.0, -height),
        max: Vec3::new(1.0, 1.0, height),
    };
    let mut nodes = vec![Node::NOTHING; TRIES + 2];
    for (i, node) in nodes[..=TRIES].iter_mut().enumerate() {
        node.set(0, &bounds, inner(i + 1));
    }
    let mut tree = Tree::default();
    tree.push((nodes, vec![]), Numbers::prims(0)).expect("a tree");
    tree.spread = UNIT;
    let rays: Vec<Ray> = (0..(TRIALS * GROUP) as u32)
        .map(|i| Ray::segment(Vec3::new(-2.0, 0.0, unit(i, 0) - 0.5), Vec3::new(4.0, 0.01, 0.01), 1.0))
        .collect();
    let list: Vec<u32> = (0..rays.len() as u32).collect();
    let mut heads = Heads::new();
    heads.begin(&tree);
    for at in 0..list.len() {
        heads.passed();
        heads.next(Portable, &tree, &rays, &list, at);
    }
    heads.verdict()
}

#[test]
fn heads_pay_where_the_rays_of_a_group_come_to_what_is_opened_for_them() {
    assert_eq!(pays(0.6), Some(true));
    // As much is opened, and one ray of fifty comes to it.
    assert_eq!(pays(1e-3), Some(false));
}
