//! Intersection of the stream's rays with analytic primitives: in blocks of one kind, and by the scalar routines of the
//! shapes where these tell nothing.

use super::{
    query::Best,
    ray_state::{InstanceState, RayState},
    slot_set::SLOTS,
};
use crate::{
    geometry::{Geometry, InstanceId, PlacedShape, PrimId, shape_block::ShapeBlock, slab::Slabs},
    math::{Dispatch, Ray, Vec3, block::LANES},
    shape::{Attempt, Shape, ShapeHit},
};

/// The shapes that rays have reached in a pass, by kind.
pub struct ShapeQueue {
    visits: [[Visit; SLOTS]; Shape::KINDS],
    counts: [usize; Shape::KINDS],
}

/// A slot and the shape that its ray has reached, by its index among the shapes.
#[derive(Clone, Copy)]
struct Visit {
    slot: u32,
    shape: u32,
}

impl ShapeQueue {
    pub fn new() -> Self {
        Self {
            visits: [[Visit { slot: 0, shape: 0 }; SLOTS]; Shape::KINDS],
            counts: [0; Shape::KINDS],
        }
    }

    /// Adds the primitive `prim` for the ray of a slot; each slot has at most one.
    #[inline(always)]
    pub fn add(&mut self, slot: usize, prim: u32, geometry: &Geometry) {
        let shape = prim - geometry.triangles.len() as u32;
        let kind = geometry.shapes[shape as usize].shape.kind();
        self.visits[kind][self.counts[kind] % SLOTS] = Visit {
            slot: slot as u32,
            shape,
        };
        self.counts[kind] += 1;
    }

    /// Tests the shapes in the queue and empties it. Returns the set of slots whose rays were shortened or blocked.
    ///
    /// A function of its own: see [`super::packet`].
    #[inline(never)]
    pub fn test(
        &mut self,
        on: impl Dispatch,
        slots: &mut [RayState; SLOTS],
        inside: &mut [InstanceState; SLOTS],
        geometry: &Geometry,
        rays: &[Ray],
    ) -> u64 {
        let mut nearer = 0;
        let mut block = ShapeBlock::EMPTY;
        for (visits, count) in self.visits.iter().zip(&mut self.counts) {
            for visits in visits[..*count].chunks(LANES) {
                nearer |= test_block(on, &mut block, visits, slots, inside, geometry, rays);
            }
            *count = 0;
        }
        nearer
    }
}

/// Tests up to [`LANES`] shapes of one kind.
#[inline(always)]
fn test_block<'a>(
    on: impl Dispatch,
    block: &mut ShapeBlock<'a>,
    visits: &[Visit],
    slots: &mut [RayState; SLOTS],
    inside: &mut [InstanceState; SLOTS],
    geometry: &'a Geometry,
    rays: &[Ray],
) -> u64 {
    for (lane, visit) in visits.iter().enumerate() {
        let slot = &slots[visit.slot as usize % SLOTS];
        let (ray, slabs) = slot.ray_and_slabs(rays);
        block.set(lane, geometry, &geometry.shapes[visit.shape as usize], &ray, slabs.inv);
    }
    block.test(on, &geometry.shapes[visits[0].shape as usize].shape);
    let mut nearer = 0;
    for (lane, visit) in visits.iter().enumerate() {
        let number = visit.slot as usize % SLOTS;
        let slot = &mut slots[number];
        let Attempt { hit, answer } = block.attempt(lane);
        let hit = match answer {
            Attempt::MISSES => continue,
            Attempt::MEETS => hit,
            _ => match slot.intersect(&geometry.shapes[visit.shape as usize], geometry, rays) {
                None => continue,
                Some(hit) => hit,
            },
        };
        let key = PrimId::new(geometry.triangles.len() as u32 + visit.shape).key(0);
        if slot.best.loses_to(hit.t, key) {
            slot.set_best(Best {
                t: hit.t,
                u: hit.u,
                v: hit.v,
                key,
            });
            inside[number].best = InstanceId::NONE;
            nearer |= 1 << number;
        }
    }
    nearer
}

impl RayState {
    /// Returns the slot's ray in world space up to its nearest hit, and as it is clipped to the bounds of shapes. Shapes are
    /// in world space, and so is the slot's line where it reaches one.
    #[inline(always)]
    fn ray_and_slabs(&self, rays: &[Ray]) -> (Ray, Slabs) {
        let ray = Ray {
            tmax: self.best.t,
            ..rays[self.ray as usize]
        };
        let [x, y, z] = self.state.inv;
        let slabs = Slabs {
            o: ray.o,
            inv: Vec3::new(x, y, z),
        };
        (ray, slabs)
    }

    /// Intersects the slot's ray with a shape.
    #[cold]
    #[inline(never)]
    fn intersect(&self, placed: &PlacedShape, geometry: &Geometry, rays: &[Ray]) -> Option<ShapeHit> {
        let (ray, slabs) = self.ray_and_slabs(rays);
        geometry.intersect_shape(placed, &ray, || slabs)
    }
}
