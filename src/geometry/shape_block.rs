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
    /// The rays in world space.
    rays: [Ray; LANES],
    inv: [Vec3; LANES],
    /// The bounds to which hits are clipped.
    bounds: [Aabb; LANES],
}

impl<'a> ShapeBlock<'a> {
    pub const EMPTY: Self = Self {
        local: RayBlock::EMPTY,
        rays: [Ray::NONE; LANES],
        inv: [Vec3::ZERO; LANES],
        bounds: [Aabb::UNBOUNDED; LANES],
    };

    /// Sets the ray and the shape of a lane; `inv` is [`Slabs::inv`] of the ray.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, geometry: &'a Geometry, placed: &'a PlacedShape, ray: &Ray, inv: Vec3) {
        let lane = lane % LANES;
        self.local.rays[lane] = match geometry.transform(placed) {
            None => *ray,
            Some(t) => t.ray_to_local(ray),
        };
        self.local.shapes[lane] = &placed.numbers;
        (self.rays[lane], self.inv[lane]) = (*ray, inv);
        self.bounds[lane] = *placed.clip_bounds();
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
        let (mut o, mut inv): ([Each; 3], [Each; 3]) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        let (mut min, mut max): ([Each; 3], [Each; 3]) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        let (mut tmin, mut tmax) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            set(&mut o, i, block.rays[i].o);
            set(&mut inv, i, block.inv[i]);
            set(&mut min, i, block.bounds[i].min);
            set(&mut max, i, block.bounds[i].max);
            (tmin[i], tmax[i]) = (block.rays[i].tmin, block.rays[i].tmax);
        }
        for i in 0..LANES {
            let slabs = Slabs {
                o: get(&o, i),
                inv: get(&inv, i),
            };
            let own = Aabb {
                min: get(&min, i),
                max: get(&max, i),
            };
            let (t, meets) = slabs.clamp(block.local.t[i], &own);
            let meets = meets & (t > tmin[i]) & (t <= tmax[i]);
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
