//! Blocks of rays in world space that are tested at once, each with a shape of its own; all are of one kind.

use super::{
    arrays::{Geometry, PlacedShape},
    slab::Slabs,
};
use crate::{
    math::{
        Aabb, Dispatch, Ray, Vec3, VectorLoop,
        block::{Each, LANES, get, set},
    },
    shape::{Attempt, RayBlock, Shape, ShapeHit},
};

/// A block of rays. It gives the results of [`Geometry::intersect_shape`].
#[derive(Clone, Debug)]
pub(crate) struct ShapeBlock<'a> {
    local: RayBlock<'a>,
    /// The rays in world space, and [`Slabs::inv`] of each.
    o: [Each; 3],
    inv: [Each; 3],
    tmin: Each,
    tmax: Each,
    /// The corners of the bounds to which hits are clipped.
    min: [Each; 3],
    max: [Each; 3],
}

impl<'a> ShapeBlock<'a> {
    pub const EMPTY: Self = Self {
        local: RayBlock::EMPTY,
        o: [[0.0; LANES]; 3],
        inv: [[0.0; LANES]; 3],
        tmin: [0.0; LANES],
        tmax: [0.0; LANES],
        min: [[0.0; LANES]; 3],
        max: [[0.0; LANES]; 3],
    };

    /// Sets the ray and the shape of a lane; `inv` is [`Slabs::inv`] of the ray.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, geometry: &'a Geometry, placed: &'a PlacedShape, ray: &Ray, inv: Vec3) {
        let lane = lane % LANES;
        match geometry.transform(placed) {
            None => self.local.set(lane, ray, &placed.numbers),
            Some(t) => self.local.set(lane, &t.ray_to_local(ray), &placed.numbers),
        }
        set(&mut self.o, lane, ray.o);
        set(&mut self.inv, lane, inv);
        (self.tmin[lane], self.tmax[lane]) = (ray.tmin, ray.tmax);
        let bounds = placed.clip_bounds();
        set(&mut self.min, lane, bounds.min);
        set(&mut self.max, lane, bounds.max);
    }

    /// Tests all lanes; their shapes are of the kind of `shape`.
    #[inline(always)]
    pub fn test(&mut self, on: impl Dispatch, shape: &Shape) {
        shape.attempt_block(on, &mut self.local);
        on.dispatch(Clips(self));
    }

    /// Returns the result of a lane.
    #[inline(always)]
    pub fn attempt(&self, lane: usize) -> Attempt {
        let block = &self.local;
        Attempt {
            hit: ShapeHit {
                t: block.t[lane],
                u: block.u[lane],
                v: block.v[lane],
            },
            answer: block.answer[lane],
        }
    }
}

/// Clips the hits of a block to the bounds of their shapes and to the extents of their rays.
struct Clips<'a, 'b>(&'a mut ShapeBlock<'b>);

impl VectorLoop for Clips<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let block = self.0;
        for i in 0..LANES {
            let slabs = Slabs {
                o: get(&block.o, i),
                inv: get(&block.inv, i),
            };
            let own = Aabb {
                min: get(&block.min, i),
                max: get(&block.max, i),
            };
            let (t, meets) = slabs.clamp(block.local.t[i], &own);
            let meets = meets & (t > block.tmin[i]) & (t <= block.tmax[i]);
            let answer = block.local.answer[i];
            block.local.t[i] = t;
            block.local.answer[i] = if meets | (answer == Attempt::UNKNOWN) {
                answer
            } else {
                Attempt::MISSES
            };
        }
    }
}
