//! Every primitive for every ray: slow, and by definition right.
//!
//! All other accelerators are compared with this one, bit for bit.

use std::{sync::Arc, time::Instant};

use super::{Accelerator, BuildError, BuildStats, Geometry, Hit, PrimRef, RayCost, prims::Prims};
use crate::math::Ray;

/// No structure at all.
pub struct Linear {
    geometry: Arc<Geometry>,
    stats: BuildStats,
}

impl Linear {
    pub fn build(geometry: Arc<Geometry>) -> Result<Self, BuildError> {
        let start = Instant::now();
        Prims::new(&geometry)?;
        let stats = BuildStats {
            build_time: start.elapsed(),
            prims: geometry.prim_count(),
            ..BuildStats::default()
        };
        Ok(Self { geometry, stats })
    }

    fn prims(&self) -> impl Iterator<Item = PrimRef> {
        (0..self.geometry.prim_count() as u32).map(PrimRef::new)
    }
}

impl Accelerator for Linear {
    fn nearest(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            let mut ray = *ray;
            *hit = None;
            for prim in self.prims() {
                self.geometry.keep_nearest(prim, &mut ray, hit);
            }
        }
    }

    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]) {
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = self.prims().any(|prim| self.geometry.intersect(prim, ray).is_some());
        }
    }

    fn cost(&self, rays: &[Ray], costs: &mut [RayCost]) {
        for (_, cost) in rays.iter().zip(costs) {
            *cost = RayCost {
                nodes: 0,
                prims: self.geometry.prim_count() as u32,
            };
        }
    }

    fn stats(&self) -> BuildStats {
        self.stats
    }

    fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }
}
