//! Rays in flight at leaves with triangles.
//!
//! Triangles lie in blocks of four, and vectors hold eight: two blocks are tested at once, each with its own ray.

use std::ptr;

use super::{
    super::wide::node::{Block, MAX_LEAF},
    inflight::Inside,
    lanes::{Floats, Level, Mask},
    query::{Best, Query},
    slot::Slot,
    triangle::{self, Candidates, Vec3s, each, load3},
    waiting::SLOTS,
};

/// The most blocks that the rays of a pass can come to.
const MOST: usize = SLOTS * MAX_LEAF;

/// A block that a slot's ray has come to.
#[derive(Clone, Copy)]
struct Visit {
    slot: usize,
    block: *const Block,
}

/// The blocks that rays have come to in a pass.
pub struct Visits {
    list: [Visit; MOST],
    count: usize,
    /// Where pairs of which something may be met begin in the list.
    met: [usize; MOST / 2],
}

impl Visits {
    pub fn new() -> Self {
        let nothing = Visit {
            slot: 0,
            block: ptr::null(),
        };
        Self {
            list: [nothing; MOST],
            count: 0,
            met: [0; MOST / 2],
        }
    }

    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds the blocks of a leaf; of each slot one leaf at most.
    #[inline(always)]
    pub fn add<L: Level>(&mut self, level: L, slot: usize, blocks: &[Block]) {
        level.prefetch::<3>(blocks.as_ptr().cast());
        for block in blocks {
            self.list[self.count % MOST] = Visit { slot, block };
            self.count += 1;
        }
    }

    /// A block and the one behind it; the last one twice where it is left over.
    #[inline(always)]
    fn pair(&self, at: usize) -> [Visit; 2] {
        let last = (self.count - 1).min(at + 1);
        [self.list[at % MOST], self.list[last % MOST]]
    }

    /// Tests all of them; the set of slots whose rays end nearer now, or are done where any hit will do.
    ///
    /// # Safety
    /// The blocks that were added still exist.
    #[inline(always)]
    pub unsafe fn test<L: Level, Q: Query, const INSTANCES: bool>(
        &mut self,
        level: L,
        slots: &mut [Slot; SLOTS],
        inside: &mut [Inside; SLOTS],
    ) -> u64 {
        // Whether anything is met cannot be foretold, so pairs of blocks with something first go into a list, without a branch.
        let mut count = 0;
        for at in (0..self.count.min(MOST)).step_by(2) {
            let pair = self.pair(at);
            // SAFETY: by this function's own contract.
            let blocks = pair.map(|visit| unsafe { &*visit.block });
            let candidates = candidates(level, pair.map(|visit| &slots[visit.slot % SLOTS]), blocks);
            self.met[count % (MOST / 2)] = at;
            count += usize::from(candidates.mask.bits() != 0);
        }
        let mut nearer = 0;
        for &at in &self.met[..count.min(MOST / 2)] {
            let pair = self.pair(at);
            let ids = pair.map(|visit| visit.slot % SLOTS);
            // SAFETY: by this function's own contract.
            let blocks = pair.map(|visit| unsafe { &*visit.block });
            let candidates = candidates(level, ids.map(|id| &slots[id]), blocks);
            let bits = candidates.mask.bits();
            if bits & 0b1111 != 0 {
                let half = candidates.half::<L, 0>(level);
                let [id, _] = ids;
                let found = keep::<L, Q, INSTANCES>(level, &mut slots[id], &mut inside[id], blocks[0], &half);
                nearer |= u64::from(found) << id;
            }
            if bits >> 4 != 0 {
                let half = candidates.half::<L, 1>(level);
                let [_, id] = ids;
                let found = keep::<L, Q, INSTANCES>(level, &mut slots[id], &mut inside[id], blocks[1], &half);
                nearer |= u64::from(found) << id;
            }
        }
        nearer
    }
}

/// Which triangles of two blocks the rays of two slots may hit, those of the first in the first half.
#[inline(always)]
fn candidates<L: Level>(level: L, slots: [&Slot; 2], blocks: [&Block; 2]) -> Candidates<L::F8> {
    let join = |[a, b]: [&[f32; 4]; 2]| level.join4(level.load4(a), level.load4(b));
    let [a, b] = slots.map(Slot::line);
    let row = |k: usize| level.quads(join([&a[k], &b[k]]));
    let ([x, y, z, begin], [dx, dy, dz, until], [sx, sy, ..]) = (row(0), row(1), row(2));
    let (a, b) = (slots[0].turn(&blocks[0].corners), slots[1].turn(&blocks[1].corners));
    let corner = |k: usize| -> Vec3s<L::F8> {
        let ([a0, a1, a2], [b0, b1, b2]) = (a[k], b[k]);
        each([join([a0, b0]), join([a1, b1]), join([a2, b2])], [x, y, z], L::F8::sub)
    };
    let corners = [corner(0), corner(1), corner(2)];
    let sides = triangle::sides(&corners, [sx, sy]);
    // Often one of the triangles is met somewhere, seldom between the ray's ends: one branch that can be foretold is
    // faster than two.
    let plane = triangle::plane(&corners);
    triangle::candidates([dx, dy, dz], &plane, sides, begin, until)
}

/// Keeps the nearest hit among the candidates of a block; whether there is one.
#[inline(always)]
fn keep<L: Level, Q: Query, const INSTANCES: bool>(
    level: L,
    slot: &mut Slot,
    inside: &mut Inside,
    block: &Block,
    candidates: &Candidates<L::F4>,
) -> bool {
    let [x, y, z] = slot.course.inv;
    let o = splat3(level, &slot.turn_back(&slot.o).to_array());
    let [a, b, c] = &block.corners;
    let corners = [
        load3(level, a.each_ref()),
        load3(level, b.each_ref()),
        load3(level, c.each_ref()),
    ];
    let faces = triangle::faces(&o, slot.course.negative(), &corners);
    let meets = triangle::meet(&splat3(level, &[x, y, z]), &faces, candidates);
    let (tmin, tmax) = (level.splat4(slot.course.tmin), level.splat4(slot.best.t));
    let within = tmin.lt(meets.t).and(meets.t.le(tmax));
    let mut hits = within.and(meets.valid).bits();
    if Q::ANY && hits != 0 {
        slot.best.id = 0;
        return true;
    }
    let found = hits != 0;
    let (t, u, v) = (meets.t.to_array(), meets.u.to_array(), meets.v.to_array());
    while hits != 0 {
        let k = hits.trailing_zeros() as usize & 3;
        hits &= hits - 1;
        let again = INSTANCES && t[k] == slot.best.t && block.ids[k] == slot.best.id && inside.current < inside.best;
        if slot.best.loses_to(t[k], block.ids[k]) || again {
            slot.set_best(Best {
                t: t[k],
                u: u[k],
                v: v[k],
                id: block.ids[k],
            });
            if INSTANCES {
                inside.best = inside.current;
            }
        }
    }
    found
}

#[inline(always)]
fn splat3<L: Level>(level: L, v: &[f32; 3]) -> Vec3s<L::F4> {
    [level.splat4(v[0]), level.splat4(v[1]), level.splat4(v[2])]
}
