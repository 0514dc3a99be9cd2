//! A linear scan: every ray is tested with every primitive. It is slow, and it is the reference.
//!
//! All other accelerators are compared with this one, bit for bit.

use std::{ops::Range, sync::Arc, time::Instant};

use super::{
    accelerator::{Accelerator, BuildStats, RayBatch, RayCost, UpdateReport},
    build::prims::Prims,
};
use crate::{
    geometry::{BuildError, Edit, Geometry, Hit, InstanceId, PrimId, check},
    math::{Aabb, Ray},
    simd::Isa,
};

/// An accelerator without a structure.
pub struct Linear {
    geometry: Arc<Geometry>,
    /// The triangles and shapes that are in no group.
    world: Vec<Range<u32>>,
    /// The bounds of groups, for validation.
    groups: Vec<Aabb>,
    simd: Isa,
    stats: BuildStats,
}

impl Linear {
    pub fn build(geometry: Arc<Geometry>, simd: Isa) -> Result<Self, BuildError> {
        let start = Instant::now();
        check::geometry(&geometry)?;
        let groups: Vec<Aabb> = geometry.groups.iter().map(|g| geometry.group_bounds(g)).collect();
        Prims::top(&geometry, &Aabb::EMPTY, &groups)?;
        let mut world = geometry.world_triangles();
        world.push(geometry.triangles.len() as u32..geometry.prim_count() as u32);
        let stats = BuildStats {
            build_time: start.elapsed(),
            ..BuildStats::of(&geometry)
        };
        Ok(Self {
            geometry,
            world,
            groups,
            simd,
            stats,
        })
    }

    /// Calls `test` with every primitive, its instance and the ray in its space, until it returns
    /// `false`.
    fn all(&self, ray: &mut Ray, mut test: impl FnMut(PrimId, InstanceId, &mut Ray) -> bool) {
        for prim in self.world.iter().cloned().flatten() {
            if !test(PrimId::new(prim), InstanceId::NONE, ray) {
                return;
            }
        }
        for (placed, number) in self.geometry.instances.iter().zip(0..) {
            let mut local = self.geometry.enter(placed, ray);
            for prim in self.geometry.groups[placed.group as usize].triangles.clone() {
                if !test(PrimId::new(prim), InstanceId(number), &mut local) {
                    return;
                }
            }
            ray.tmax = local.tmax;
        }
    }
}

impl Accelerator for Linear {
    fn nearest_batch(&self, batch: RayBatch<'_>, hits: &mut [Option<Hit>]) {
        let rays = batch.rays;
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = None;
            self.all(&mut ray.clone(), |prim, instance, ray| {
                self.geometry.keep_nearest(prim, instance, ray, hit);
                true
            });
        }
    }

    fn occluded_batch(&self, batch: RayBatch<'_>, blocked: &mut [bool]) {
        let rays = batch.rays;
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = false;
            self.all(&mut ray.clone(), |prim, _, ray| {
                *blocked = self.geometry.intersect(prim, ray).is_some();
                !*blocked
            });
        }
    }

    fn cost(&self, rays: &[Ray], costs: &mut [RayCost]) {
        for (_, cost) in rays.iter().zip(costs) {
            *cost = RayCost {
                nodes: 0,
                prims: u32::try_from(self.stats.seen).unwrap_or(u32::MAX),
            };
        }
    }

    fn update(&mut self, edit: &Edit) -> Result<UpdateReport, BuildError> {
        let changed = edit.apply(&mut self.geometry, &self.groups)?;
        for group in changed.groups {
            let group = group as usize;
            self.groups[group] = self.geometry.group_bounds(&self.geometry.groups[group]);
        }
        Ok(UpdateReport::default())
    }

    fn simd(&self) -> Isa {
        self.simd
    }

    fn stats(&self) -> BuildStats {
        self.stats
    }

    fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }
}
