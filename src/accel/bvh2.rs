//! A binary tree, traversed one ray at a time in plain Rust: simple enough to trust, and a yardstick.

use std::{sync::Arc, time::Instant};

use super::{
    Accelerator, BuildError, BuildStats, Geometry, Hit, PrimRef, Quality, RayCost,
    binary::{self, Flat},
    nearest_unbounded,
    prims::Prims,
    slab::Planes,
};
use crate::math::Ray;

/// A binary tree over boxes, one primitive a leaf.
pub struct Bvh2 {
    geometry: Arc<Geometry>,
    nodes: Vec<Flat>,
    ids: Vec<u32>,
    unbounded: Vec<PrimRef>,
    reach: f32,
    stats: BuildStats,
}

impl Bvh2 {
    pub fn build(geometry: Arc<Geometry>, quality: Quality) -> Result<Self, BuildError> {
        let start = Instant::now();
        let prims = Prims::new(&geometry)?;
        let nodes =
            binary::build(&prims, quality).map_or_else(Vec::new, |tree| binary::flatten(&tree, 0, &prims.boxes));
        let stats = BuildStats {
            build_time: start.elapsed(),
            node_count: nodes.len(),
            bytes: size_of_val(&nodes[..]) + size_of_val(&prims.ids[..]),
            prims: geometry.prim_count(),
        };
        Ok(Self {
            geometry,
            nodes,
            ids: prims.ids,
            unbounded: prims.unbounded,
            reach: prims.reach,
            stats,
        })
    }

    /// Visits the leaves that `ray` may meet, nearer boxes first. `leaf` tests a primitive, may shorten the ray, and
    /// says whether to go on.
    fn walk(
        &self,
        ray: &mut Ray,
        stack: &mut Vec<(u32, f32)>,
        cost: &mut RayCost,
        mut leaf: impl FnMut(PrimRef, &mut Ray) -> Walk,
    ) {
        let planes = Planes::new(ray, self.reach);
        stack.clear();
        let Some(root) = self.nodes.first() else { return };
        cost.nodes += 1;
        if let Some(t) = planes.enter(&root.bounds, ray.tmin, ray.tmax) {
            stack.push((0, t));
        }
        while let Some((index, t)) = stack.pop() {
            if t > ray.tmax {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.is_leaf() {
                cost.prims += 1;
                match leaf(PrimRef::new(self.ids[node.leaf as usize]), ray) {
                    Walk::GoOn => continue,
                    Walk::Stop => return,
                }
            }
            cost.nodes += 2;
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
    }
}

/// What comes after a leaf.
enum Walk {
    GoOn,
    Stop,
}

impl Accelerator for Bvh2 {
    fn nearest(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        let mut stack = Vec::new();
        for (ray, hit) in rays.iter().zip(hits) {
            let mut ray = *ray;
            *hit = None;
            nearest_unbounded(&self.geometry, &self.unbounded, &mut ray, hit);
            self.walk(&mut ray, &mut stack, &mut RayCost::default(), |prim, ray| {
                self.geometry.keep_nearest(prim, ray, hit);
                Walk::GoOn
            });
        }
    }

    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]) {
        let mut stack = Vec::new();
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = self
                .unbounded
                .iter()
                .any(|&p| self.geometry.intersect(p, ray).is_some());
            if *blocked {
                continue;
            }
            self.walk(&mut ray.clone(), &mut stack, &mut RayCost::default(), |prim, ray| {
                *blocked = self.geometry.intersect(prim, ray).is_some();
                if *blocked { Walk::Stop } else { Walk::GoOn }
            });
        }
    }

    fn cost(&self, rays: &[Ray], costs: &mut [RayCost]) {
        let mut stack = Vec::new();
        for (ray, cost) in rays.iter().zip(costs) {
            let (mut ray, mut hit) = (*ray, None);
            *cost = RayCost {
                nodes: 0,
                prims: self.unbounded.len() as u32,
            };
            nearest_unbounded(&self.geometry, &self.unbounded, &mut ray, &mut hit);
            self.walk(&mut ray, &mut stack, cost, |prim, ray| {
                self.geometry.keep_nearest(prim, ray, &mut hit);
                Walk::GoOn
            });
        }
    }

    fn stats(&self) -> BuildStats {
        self.stats
    }

    fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }
}
