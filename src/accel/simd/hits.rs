//! Which of the triangles that rays in flight may hit they hit.
//!
//! Whether they do can hardly be foretold, so nothing here branches on it: of a block the nearest hit is found on vectors, two
//! blocks at a time, and kept or not by selection. Only where several triangles are equally near is there a branch.

use std::hint::select_unpredictable;

use super::{
    super::wide::node::Block,
    inflight::Inside,
    lanes::{Floats, Level, Mask},
    query::{Best, Query},
    slot::Slot,
    triangle::{self, Crossing, Vec3s, join, join3},
};

/// What of two blocks is hit.
pub struct Hits {
    t: [f32; 8],
    u: [f32; 8],
    v: [f32; 8],
    /// The nearest ones of each block, or all where any hit will do; a bit for each.
    nearest: u32,
}

/// Decides among these `lanes` of two blocks.
#[inline(always)]
pub fn decide<L: Level, Q: Query>(
    level: L,
    [(slot, block), (slot2, block2)]: [(&Slot, &Block); 2],
    lanes: u32,
    crossing: &Crossing<L::F8>,
) -> Hits {
    let ([a, b, c], [a2, b2, c2]) = (&block.corners, &block2.corners);
    let corners = [
        join3(level, a.each_ref(), a2.each_ref()),
        join3(level, b.each_ref(), b2.each_ref()),
        join3(level, c.each_ref(), c2.each_ref()),
    ];
    let o = three(level, &slot.origin(), &slot2.origin());
    let inv = three(level, &slot.course.inv, &slot2.course.inv);
    let meets = triangle::meet(triangle::stretch_any(&o, &inv, &corners), crossing);
    let tmin = both(level, slot.course.tmin, slot2.course.tmin);
    let lanes = join(level, set(lanes), set(lanes >> 4));
    let within = tmin.lt(meets.t).and(meets.valid).and(lanes.lt(level.splat8(0.0)));
    let nearest = if Q::ANY {
        within.and(meets.t.le(both(level, slot.best.t, slot2.best.t)))
    } else {
        let t = meets.t.select(within, level.splat8(f32::INFINITY));
        let [x, y, z, w] = level.quads(t);
        within.and(t.eq(x.min(y).min(z.min(w))))
    };
    Hits {
        t: meets.t.to_array(),
        u: meets.u.to_array(),
        v: meets.v.to_array(),
        nearest: nearest.bits(),
    }
}

/// Keeps the nearest hit of the first block (0), or of the second (1), if it is nearer than what its ray has; whether it is.
#[inline(always)]
pub fn keep<Q: Query, const INSTANCES: bool>(
    hits: &Hits,
    which: usize,
    slot: &mut Slot,
    inside: &mut Inside,
    block: &Block,
) -> bool {
    let first = 4 * (which & 1);
    let nearest = hits.nearest >> first & 0b1111;
    let best = slot.best;
    if Q::ANY {
        slot.best.id = select_unpredictable(nearest != 0, 0, best.id);
        return nearest != 0;
    }
    let mut k = nearest.trailing_zeros() as usize & 3;
    if nearest & nearest.wrapping_sub(1) != 0 {
        k = lowest(nearest, block);
    }
    let (t, id) = (hits.t[first + k], block.ids[k]);
    let again = INSTANCES && t == best.t && id == best.id && inside.current < inside.best;
    let found = (nearest != 0) & (best.loses_to(t, id) | again);
    slot.set_best(Best {
        t: choose(found, t, best.t),
        u: choose(found, hits.u[first + k], best.u),
        v: choose(found, hits.v[first + k], best.v),
        id: select_unpredictable(found, id, best.id),
    });
    if INSTANCES {
        inside.best = select_unpredictable(found, inside.current, inside.best);
    }
    found
}

/// Of those triangles of a block that are equally near, which happens along edges, the one with the lowest number.
#[cold]
#[inline(never)]
fn lowest(lanes: u32, block: &Block) -> usize {
    let lanes = (0..4).filter(|k| lanes >> k & 1 == 1);
    lanes.min_by_key(|&k| block.ids[k]).unwrap_or(0)
}

#[inline(always)]
fn choose(new: bool, a: f32, b: f32) -> f32 {
    f32::from_bits(select_unpredictable(new, a.to_bits(), b.to_bits()))
}

/// The first four lanes for the one block, the others for the other.
#[inline(always)]
fn both<L: Level>(level: L, a: f32, b: f32) -> L::F8 {
    level.join4(level.splat4(a), level.splat4(b))
}

#[inline(always)]
fn three<L: Level>(level: L, a: &[f32; 3], b: &[f32; 3]) -> Vec3s<L::F8> {
    [
        both(level, a[0], b[0]),
        both(level, a[1], b[1]),
        both(level, a[2], b[2]),
    ]
}

/// Less than zero in these lanes.
#[inline(always)]
fn set(lanes: u32) -> &'static [f32; 4] {
    &SETS[lanes as usize & 0b1111]
}

static SETS: [[f32; 4]; 16] = {
    let mut sets = [[0.0; 4]; 16];
    let mut bits = 0;
    while bits < 64 {
        let (set, lane) = (bits / 4, bits % 4);
        if set >> lane & 1 == 1 {
            sets[set][lane] = -1.0;
        }
        bits += 1;
    }
    sets
};
