//! The default accelerator: an eight-wide tree and kernels for many rays at once.
//!
//! obvhs builds a binary tree ([`super::binary`]), [`build`] makes a wide one of it. Triangles lie in blocks of four with
//! their corners, so that a leaf reads nothing else; an analytic primitive is a leaf of its own.
//!
//! [`super::simd`] traces: packets of 16 rays where [`batch`] finds that they stay together, 64 rays in flight where they
//! have nothing in common.

use std::{cell::RefCell, sync::Arc, time::Instant};

use rayon::prelude::*;

use super::{
    Accelerator, BuildError, BuildStats, Geometry, Hit, PrimRef, Quality, RayCost, binary, nearest_unbounded,
    prims::Prims,
    simd::{self, Pick, Scratch, Simd, Tree},
};
use crate::math::{Aabb, Ray};

mod batch;
mod build;
mod collapse;
mod cost;
pub(super) mod node;

thread_local! {
    /// The kernels' memory. One for a thread, since allocating it for a batch of a thousand rays costs 6 %.
    static SCRATCH: RefCell<(Scratch, Vec<u32>)> = RefCell::new((Scratch::new(), Vec::new()));
}

/// An eight-wide tree.
pub struct Wide {
    geometry: Arc<Geometry>,
    /// `None` where nothing has a box.
    tree: Option<Tree>,
    unbounded: Vec<PrimRef>,
    /// The longest side of the box around the tree.
    size: f32,
    simd: Simd,
    stats: BuildStats,
}

impl Wide {
    pub fn build(geometry: Arc<Geometry>, quality: Quality, simd: Simd) -> Result<Self, BuildError> {
        let start = Instant::now();
        let prims = Prims::new(&geometry)?;
        let count = geometry.prim_count();
        if count > node::MAX_PRIMS {
            return Err(BuildError::TooMany { count });
        }
        let tree = match binary::build(&prims, quality) {
            None => None,
            Some(binary) => {
                let (nodes, blocks) = build::build(&binary, &prims, &geometry);
                Some(Tree::new(nodes, blocks, count, prims.reach).ok_or(BuildError::TooMany { count })?)
            }
        };
        let all = prims.boxes.par_iter().copied().reduce(|| Aabb::EMPTY, Aabb::union);
        let size = all.extent().max_element();
        let stats = BuildStats {
            build_time: start.elapsed(),
            node_count: tree.as_ref().map_or(0, |tree| tree.nodes().len()),
            bytes: tree.as_ref().map_or(0, Tree::bytes),
            prims: count,
        };
        Ok(Self {
            geometry,
            tree,
            unbounded: prims.unbounded,
            size,
            simd,
            stats,
        })
    }

    /// What lies outside the tree: the state that a ray enters the tree with.
    fn outside(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = None;
        nearest_unbounded(&self.geometry, &self.unbounded, &mut ray.clone(), &mut hit);
        hit
    }
}

impl Accelerator for Wide {
    fn nearest(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        let hits = &mut hits[..rays.len()];
        hits.fill(None);
        if !self.unbounded.is_empty() {
            for (ray, hit) in rays.iter().zip(&mut *hits) {
                *hit = self.outside(ray);
            }
        }
        let Some(tree) = &self.tree else { return };
        let coherent = batch::is_coherent(rays, self.size);
        SCRATCH.with_borrow_mut(|(scratch, left)| {
            let (simd, geometry) = (self.simd, &*self.geometry);
            if coherent {
                left.clear();
                simd::nearest_packets(simd, tree, geometry, rays, hits, scratch, left);
                simd::nearest_inflight(simd, tree, geometry, rays, Pick::Some(left), hits, scratch);
            } else {
                simd::nearest_inflight(simd, tree, geometry, rays, Pick::All, hits, scratch);
            }
        });
    }

    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]) {
        let blocked = &mut blocked[..rays.len()];
        blocked.fill(false);
        if !self.unbounded.is_empty() {
            for (ray, blocked) in rays.iter().zip(&mut *blocked) {
                *blocked = self.outside(ray).is_some();
            }
        }
        let Some(tree) = &self.tree else { return };
        SCRATCH.with_borrow_mut(|(scratch, _)| {
            simd::occluded_inflight(self.simd, tree, &self.geometry, rays, blocked, scratch);
        });
    }

    fn cost(&self, rays: &[Ray], costs: &mut [RayCost]) {
        for (ray, cost) in rays.iter().zip(costs) {
            *cost = RayCost {
                nodes: 0,
                prims: self.unbounded.len() as u32,
            };
            let Some(tree) = &self.tree else { continue };
            let best = self.outside(ray);
            let mut ray = *ray;
            ray.tmax = best.map_or(ray.tmax, |hit| hit.t);
            cost::count(tree, &self.geometry, ray, best, cost);
        }
    }

    fn stats(&self) -> BuildStats {
        self.stats
    }

    fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }
}
