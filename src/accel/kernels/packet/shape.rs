//! Intersection of a packet with an analytic primitive: first with its bounds, then with a
//! vectorised estimate, and then with the primitive's scalar routine for the rays that are left.

use super::rays::{Packet, load16s};
use crate::{
    accel::kernels::{query::Best, ray16::RAYS},
    geometry::{
        Geometry, PrimId,
        shape_block::ShapeBlock,
        slab::{END_PADDING, EXIT_PADDING, MIN_PADDING, ORIGIN_PADDING, Slabs},
    },
    math::{Aabb, Ray, Vec3, block::LANES},
    shape::{Attempt, ShapeHit},
    simd::lanes::{Floats, Mask, SimdLevel},
};

/// Up to this number, rays are tested one by one.
const MAX_SINGLE_RAYS: u32 = 3;

/// Tests shape `index` of the geometry's primitives. Returns whether it is the nearest hit of any
/// ray.
#[inline(always)]
pub fn shape_step<L: SimdLevel>(level: L, packet: &mut Packet, index: u32, geometry: &Geometry, rays: &[Ray]) -> bool {
    let asked = packet.meets(level, &geometry.bounds(PrimId::new(index)));
    asked != 0 && test(level, packet, index, asked, geometry, rays)
}

impl Packet {
    /// Returns ray `k`, prepared for clipping to a shape's bounds.
    #[inline(always)]
    fn slabs(&self, k: usize) -> Slabs {
        Slabs {
            o: Vec3::new(self.o[0].0[k], self.o[1].0[k], self.o[2].0[k]),
            inv: Vec3::new(self.inv[0].0[k], self.inv[1].0[k], self.inv[2].0[k]),
        }
    }

    /// Returns the set of rays that may intersect a box.
    #[inline(always)]
    fn meets<L: SimdLevel>(&self, level: L, bounds: &Aabb) -> u32 {
        let (o, inv) = (load16s(level, &self.o), load16s(level, &self.inv));
        let negative = self.state.negative();
        let mut enter = level.load16(&self.tmins.0);
        let mut leave = level.load16(&self.t.0).mul(level.splat16(END_PADDING));
        for axis in 0..3 {
            let (least, most) = (level.splat16(bounds.min[axis]), level.splat16(bounds.max[axis]));
            let pad = o[axis]
                .abs()
                .mul(level.splat16(ORIGIN_PADDING))
                .add(level.splat16(4.0 * MIN_PADDING));
            let (less, more) = (o[axis].sub(pad), o[axis].add(pad));
            let (near, far) = if negative[axis] {
                (most.sub(less), least.sub(more))
            } else {
                (least.sub(more), most.sub(less))
            };
            enter = near.mul(inv[axis]).max(enter);
            leave = far.mul(inv[axis]).min(leave);
        }
        enter.le(leave.mul(level.splat16(EXIT_PADDING))).bits()
    }
}

/// Tests a shape with the rays whose bits are set. A function of its own, so that none of the
/// kernel's vectors are live in code where the level's instructions are not enabled.
#[inline(never)]
fn test<L: SimdLevel>(
    level: L,
    packet: &mut Packet,
    index: u32,
    asked: u32,
    geometry: &Geometry,
    rays: &[Ray],
) -> bool {
    let Some(placed) = geometry.shape(PrimId::new(index)) else {
        return false;
    };
    let in_blocks = asked.count_ones() >= MAX_SINGLE_RAYS;
    let mut block = ShapeBlock::EMPTY;
    let mut left = packet.used() & asked;
    let mut nearer = false;
    while left != 0 {
        let (mut lanes, mut count) = ([0; LANES], 0);
        while left != 0 && count < LANES {
            lanes[count] = left.trailing_zeros() as usize % RAYS;
            left &= left - 1;
            count += 1;
        }
        let lanes = &lanes[..count];
        if in_blocks {
            for (lane, &k) in lanes.iter().enumerate() {
                block.set(lane, geometry, placed, &packet.line(k, rays), packet.slabs(k).inv);
            }
            block.test(level, &placed.shape);
        }
        for (lane, &k) in lanes.iter().enumerate() {
            let Attempt { hit, answer } = block.attempt(lane);
            let hit = match answer {
                Attempt::MISSES => None,
                Attempt::MEETS => Some(hit),
                _ => geometry.intersect_shape(placed, &packet.line(k, rays), || packet.slabs(k)),
            };
            nearer |= hit.is_some_and(|hit| packet.keep_nearer(k, &hit, PrimId::new(index).key(0)));
        }
    }
    nearer
}

impl Packet {
    /// Returns the ray of a lane up to its nearest hit.
    #[inline(always)]
    fn line(&self, k: usize, rays: &[Ray]) -> Ray {
        Ray {
            tmax: self.t.0[k],
            ..rays[self.ray(k) as usize]
        }
    }

    /// Stores the hit of a lane, with this key, if it is the nearest. Returns whether it is.
    #[inline(always)]
    fn keep_nearer(&mut self, k: usize, hit: &ShapeHit, key: u32) -> bool {
        let best = Best {
            t: self.t.0[k],
            u: self.u.0[k],
            v: self.v.0[k],
            key: self.key.0[k].to_bits(),
        };
        if !best.loses_to(hit.t, key) {
            return false;
        }
        (self.t.0[k], self.u.0[k], self.v.0[k]) = (hit.t, hit.u, hit.v);
        self.key.0[k] = f32::from_bits(key);
        true
    }
}
