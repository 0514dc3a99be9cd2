//! Construction of the light tree: a top-down binned build of a binary tree, which is then collapsed.
//!
//! The cost of a group is its power times the squared diagonal of its bounds times the measure of
//! its orientation cone. Splits between buckets along the axes are compared.

use super::{LightTree, binary::BinaryNode, collapse::collapse};
use crate::{
    light::LightBounds,
    math::{Aabb, Vec3},
};

const BUCKETS: usize = 12;
/// The least number of lights of a parallel task.
const PAR_MIN_LEN: usize = 2048;
/// The most lights of a group for which all axes are tried, not only the longest.
const MAX_ALL_AXES: usize = 4096;

#[derive(Clone, Copy)]
struct BuildItem {
    bounds: LightBounds,
    light: u32,
}

impl BuildItem {
    fn center(&self) -> Vec3 {
        self.bounds.bounds.center()
    }
}

impl LightTree {
    /// Builds a tree over lights with these bounds, on the threads of the current rayon pool; the tree does not depend on their
    /// number.
    pub fn build(lights: impl ExactSizeIterator<Item = LightBounds>) -> Self {
        let mut tree = Self {
            places: vec![None; lights.len()],
            ..Self::default()
        };
        let mut items: Vec<BuildItem> = (0..)
            .zip(lights)
            .map(|(light, bounds)| BuildItem { bounds, light })
            .filter(|i| i.bounds.power > 0.0 && i.bounds.bounds.is_finite())
            .collect();
        let Some(first) = items.first() else {
            return tree;
        };
        let bounds = first.bounds;
        let mut nodes = vec![BinaryNode { bounds, leaves: 1 }; 2 * items.len() - 1];
        fill(&mut items, &mut nodes);
        let lights: Vec<u32> = items.iter().map(|i| i.light).collect();
        collapse(&nodes, &lights, &mut tree);
        tree
    }
}

/// Orders `items` and writes the nodes over them, 2k - 1 for k lights; returns the bounds of all.
fn fill(items: &mut [BuildItem], nodes: &mut [BinaryNode]) -> LightBounds {
    let count = items.len();
    if let [only] = items {
        nodes[0] = BinaryNode {
            bounds: only.bounds,
            leaves: 1,
        };
        return only.bounds;
    }
    let at = split(items);
    let (left, right) = items.split_at_mut(at);
    let (root, below) = nodes.split_first_mut().expect("a group of two or more has nodes");
    let (left_nodes, right_nodes) = below.split_at_mut(2 * at - 1);
    let (l, r) = if count >= PAR_MIN_LEN {
        rayon::join(|| fill(left, left_nodes), || fill(right, right_nodes))
    } else {
        (fill(left, left_nodes), fill(right, right_nodes))
    };
    let bounds = l.union(&r);
    *root = BinaryNode {
        bounds,
        leaves: count as u32,
    };
    bounds
}

/// Orders two or more items into two non-empty groups; returns the start of the second.
fn split(items: &mut [BuildItem]) -> usize {
    let centers = Aabb::from_points(items.iter().map(BuildItem::center));
    let extent = centers.extent();
    let longest = (0..3).fold(0, |m, a| if extent[a] > extent[m] { a } else { m });
    let middle = items.len() / 2;
    if items.len() > 2 && extent[longest] > 0.0 {
        let axes = if items.len() > MAX_ALL_AXES {
            longest..longest + 1
        } else {
            0..3
        };
        let best = axes
            .filter(|&axis| extent[axis] > 0.0)
            .filter_map(|axis| cheapest(items, &centers, axis).map(|(cost, bucket)| (cost, axis, bucket)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, axis, bucket)) = best {
            return partition(items, |i| bucket_of(i, &centers, axis) <= bucket);
        }
    }
    items.select_nth_unstable_by(middle, |a, b| {
        let along = a.center()[longest].total_cmp(&b.center()[longest]);
        along.then(a.light.cmp(&b.light))
    });
    middle
}

fn bucket_of(item: &BuildItem, centers: &Aabb, axis: usize) -> usize {
    let along = (item.center()[axis] - centers.min[axis]) / (centers.max[axis] - centers.min[axis]);
    ((along * BUCKETS as f32) as usize).min(BUCKETS - 1)
}

/// The last bucket of the first group of the cheapest split along `axis`, and its cost.
fn cheapest(items: &[BuildItem], centers: &Aabb, axis: usize) -> Option<(f32, usize)> {
    let mut buckets: [Option<LightBounds>; BUCKETS] = [None; BUCKETS];
    for item in items {
        add(&mut buckets[bucket_of(item, centers, axis)], Some(&item.bounds));
    }
    let mut after = [None; BUCKETS];
    for i in (0..BUCKETS - 1).rev() {
        after[i] = after[i + 1];
        add(&mut after[i], buckets[i + 1].as_ref());
    }
    let extent = centers.extent();
    // Splits along a short axis cost more, because they make thin slices.
    let regular = extent.max_element() / extent[axis];
    let mut before = None;
    (0..BUCKETS - 1)
        .filter_map(|i| {
            add(&mut before, buckets[i].as_ref());
            let (l, r) = (before.as_ref()?, after[i].as_ref()?);
            Some((regular * (weight(l) + weight(r)), i))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

fn add(sum: &mut Option<LightBounds>, more: Option<&LightBounds>) {
    if let Some(more) = more {
        *sum = Some(sum.map_or(*more, |s| s.union(more)));
    }
}

fn weight(group: &LightBounds) -> f32 {
    group.power * group.bounds.extent().length_squared() * group.directions.measure()
}

/// Moves the items that are `first` to the front; returns their number.
fn partition(items: &mut [BuildItem], first: impl Fn(&BuildItem) -> bool) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        if first(&items[i]) {
            items.swap(i, count);
            count += 1;
        }
    }
    count
}
