//! The final test of candidate triangles for the stream's rays.
//!
//! Seldom more than one of eight triangles that were tested together is left. So each is decided
//! on its own, with the three axes of its bounds in one vector. Whether it is hit is unpredictable,
//! so the code selects results without a branch.

use std::hint::select_unpredictable;

use super::{
    query::{Best, Query},
    ray_state::{InstanceState, RayState},
    triangle::{self, Crossing, PADDING},
};
use crate::{
    accel::wide::node::TriangleBlock,
    geometry::slab::MIN_PADDING,
    simd::lanes::{Floats, Mask, SimdLevel},
};

/// The intersection of a ray and a triangle.
pub struct Meet {
    /// Whether it is behind the ray's start and, for occlusion, before its end.
    is_hit: bool,
    t: f32,
    u: f32,
    v: f32,
}

/// Intersects a slot's ray with triangle `k` of a block.
#[inline(always)]
pub fn meet<L: SimdLevel, Q: Query>(
    level: L,
    slot: &RayState,
    block: &TriangleBlock,
    k: usize,
    crossing: &Crossing<L::F4>,
) -> Meet {
    // All lanes are equal except those of the bounds, of which the first counts.
    let meets = triangle::meet(stretch(level, slot, block, k), crossing);
    let mut is_hit = meets.valid.and(level.splat4(slot.state.tmin).lt(meets.t));
    if Q::ANY {
        is_hit = is_hit.and(meets.t.le(level.splat4(slot.best.t)));
    }
    Meet {
        is_hit: is_hit.bits() & 1 == 1,
        t: meets.t.to_array()[0],
        u: meets.u.to_array()[0],
        v: meets.v.to_array()[0],
    }
}

/// Returns what [`triangle::stretch`] returns, in the first lane. The order of the axes does not
/// matter.
#[inline(always)]
fn stretch<L: SimdLevel>(level: L, slot: &RayState, block: &TriangleBlock, k: usize) -> [L::F4; 2] {
    let [a, b, c] = slot.permute_axes(&block.corners);
    let (a, b, c) = (corner(level, a, k), corner(level, b, k), corner(level, c, k));
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let pad = low.abs().max(high.abs()).mul(level.splat4(PADDING));
    let (o, tiny) = (level.load4(&slot.line()[0]), level.splat4(MIN_PADDING));
    let low = low.sub(pad).sub(o).sub(tiny);
    let high = high.add(pad).sub(o).add(tiny);
    let inv = level.rotate4(level.load4(&slot.state.rows()[0]), slot.last());
    // Reciprocals are neither zero nor infinite, so the smaller one of two products belongs to the
    // nearer face.
    let (p, q) = (low.mul(inv), high.mul(inv));
    let (near, far) = (p.min(q), p.max(q));
    [
        near.max(level.rotate4(near, 1)).max(level.rotate4(near, 2)),
        far.min(level.rotate4(far, 1)).min(level.rotate4(far, 2)),
    ]
}

/// Returns a vertex of one of four triangles.
#[inline(always)]
fn corner<L: SimdLevel>(level: L, [x, y, z]: [&[f32; 4]; 3], k: usize) -> L::F4 {
    level.load4(&[x[k], y[k], z[k], 0.0])
}

/// Stores a hit on the triangle with this key if it is nearer than the slot's hit. Returns whether it is.
#[inline(always)]
pub fn keep<Q: Query, const INSTANCES: bool>(
    meet: &Meet,
    key: u32,
    slot: &mut RayState,
    inside: &mut InstanceState,
) -> bool {
    let best = slot.best;
    let Meet { is_hit, t, u, v } = *meet;
    if Q::ANY {
        slot.best.key = select_unpredictable(is_hit, 0, best.key);
        return is_hit;
    }
    let again = INSTANCES && t == best.t && key == best.key && inside.current < inside.best;
    let found = is_hit & (best.loses_to(t, key) | again);
    slot.set_best(Best {
        t: choose(found, t, best.t),
        u: choose(found, u, best.u),
        v: choose(found, v, best.v),
        key: select_unpredictable(found, key, best.key),
    });
    if INSTANCES {
        inside.best = select_unpredictable(found, inside.current, inside.best);
    }
    found
}

#[inline(always)]
fn choose(new: bool, a: f32, b: f32) -> f32 {
    f32::from_bits(select_unpredictable(new, a.to_bits(), b.to_bits()))
}
