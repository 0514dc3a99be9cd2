//! Rays in flight at leaves with triangles.
//!
//! Triangles lie in blocks of four, and vectors hold eight: two blocks are tested at once, each with its own ray.

use std::{mem::MaybeUninit, ptr};

use super::{
    super::wide::node::{Block, MAX_LEAF},
    inflight::Inside,
    lanes::{Floats, Level, Mask},
    query::{Best, Query},
    slot::Slot,
    triangle::{self, Candidates, Crossing, Vec3s, each, load3},
    waiting::SLOTS,
};

/// The most blocks that the rays of a pass can come to.
const MOST: usize = SLOTS * MAX_LEAF;

/// A pair of blocks of which something may be met.
struct Met {
    /// Where it begins in the list.
    at: usize,
    /// Which triangles, a bit for each.
    lanes: u32,
    crossing: Crossing<[f32; 8]>,
}

/// The blocks that rays have come to in a pass.
pub struct Visits {
    /// Where the rays' slots lie.
    slots: [usize; MOST],
    blocks: [*const Block; MOST],
    met: [MaybeUninit<Met>; MOST / 2],
}

impl Visits {
    pub fn new() -> Self {
        Self {
            slots: [0; MOST],
            blocks: [ptr::null(); MOST],
            met: [const { MaybeUninit::uninit() }; MOST / 2],
        }
    }

    /// Adds the blocks of a leaf to so many others; how many there are then. The slot is told by where it lies.
    ///
    /// # Safety
    /// There is such a slot, and of each slot there is one leaf. A leaf has as many blocks as [`MAX_LEAF`] at most.
    #[inline(always)]
    pub unsafe fn add<L: Level>(&mut self, level: L, mut count: usize, slot: usize, blocks: &[Block]) -> usize {
        level.prefetch::<3>(blocks.as_ptr().cast());
        let Some((first, others)) = blocks.split_first() else {
            return count;
        };
        // SAFETY: there is room for all blocks that a leaf of each slot can have.
        unsafe { self.put(count, slot, first) };
        count += 1;
        for block in others {
            // SAFETY: as above.
            unsafe { self.put(count, slot, block) };
            count += 1;
        }
        count
    }

    /// # Safety
    /// `at` is below [`MOST`].
    #[inline(always)]
    unsafe fn put(&mut self, at: usize, slot: usize, block: *const Block) {
        debug_assert!(at < MOST);
        // SAFETY: by this function's own contract.
        unsafe {
            *self.slots.get_unchecked_mut(at) = slot;
            *self.blocks.get_unchecked_mut(at) = block;
        }
    }

    /// A block with the slot whose ray has come to it.
    ///
    /// # Safety
    /// One was added as the `at`-th, of a slot among `slots`, and still exists.
    #[inline(always)]
    unsafe fn visit<'s>(&'s self, slots: &'s [Slot; SLOTS], at: usize) -> (&'s Slot, &'s Block) {
        // SAFETY: by this function's own contract.
        unsafe {
            let slot = slots.as_ptr().with_addr(*self.slots.get_unchecked(at));
            (&*slot, &**self.blocks.get_unchecked(at))
        }
    }

    /// Tests so many of them, all that were added; the set of slots whose rays end nearer now, or are done where any hit will do.
    ///
    /// # Safety
    /// So many were added, and still exist.
    #[inline(always)]
    pub unsafe fn test<L: Level, Q: Query, const INSTANCES: bool>(
        &mut self,
        level: L,
        count: usize,
        slots: &mut [Slot; SLOTS],
        inside: &mut [Inside; SLOTS],
    ) -> u64 {
        if count % 2 == 1 {
            // The last one twice: there is room, since there is for an even number of blocks.
            (self.slots[count % MOST], self.blocks[count % MOST]) = (self.slots[count - 1], self.blocks[count - 1]);
        }
        // Whether anything is met cannot be foretold, so pairs of blocks with something first go into a list, without a branch.
        let mut found = 0;
        let mut at = 0;
        while at < count {
            // SAFETY: so many were added, by this function's own contract, and are in slots; each pair is found once at most.
            unsafe {
                let first = self.visit(slots, at);
                let second = self.visit(slots, at + 1);
                let Candidates { mask, crossing } = candidates(level, first, second);
                let lanes = mask.bits();
                self.met.get_unchecked_mut(found).write(Met {
                    at,
                    lanes,
                    crossing: crossing.to_arrays(),
                });
                found += usize::from(lanes != 0);
            }
            at += 2;
        }
        let mut nearer = 0;
        for met in &self.met[..found.min(MOST / 2)] {
            // SAFETY: so many were written.
            let Met { at, lanes, crossing } = unsafe { met.assume_init_ref() };
            for k in 0..2 {
                let lanes = lanes >> (4 * k) & 0b1111;
                if lanes == 0 {
                    continue;
                }
                let at = (at + k) % MOST;
                let id = (self.slots[at] - slots.as_ptr().addr()) / size_of::<Slot>() % SLOTS;
                // SAFETY: by this function's own contract.
                let block = unsafe { &*self.blocks[at] };
                let crossing = crossing.half(level, k);
                let found = keep::<L, Q, INSTANCES>(level, &mut slots[id], &mut inside[id], block, lanes, &crossing);
                nearer |= u64::from(found) << id;
            }
        }
        nearer
    }
}

/// Which triangles of two blocks the rays of two slots may hit, those of the first in the first half.
#[inline(always)]
fn candidates<L: Level>(level: L, first: (&Slot, &Block), second: (&Slot, &Block)) -> Candidates<L::F8> {
    let ([o, d, shear], [o2, d2, shear2]) = (first.0.line(), second.0.line());
    let [x, y, z, begin] = level.quads(join(level, o, o2));
    let [dx, dy, dz, until] = level.quads(join(level, d, d2));
    let [sx, sy, ..] = level.quads(join(level, shear, shear2));
    let ([a, b, c], [a2, b2, c2]) = (first.0.turn(&first.1.corners), second.0.turn(&second.1.corners));
    let corners = [
        each(join3(level, a, a2), [x, y, z], L::F8::sub),
        each(join3(level, b, b2), [x, y, z], L::F8::sub),
        each(join3(level, c, c2), [x, y, z], L::F8::sub),
    ];
    let sides = triangle::sides(&corners, [sx, sy]);
    // Often one of the triangles is met somewhere, seldom between the ray's ends: one branch that can be foretold is
    // faster than two.
    let plane = triangle::plane(&corners);
    triangle::candidates([dx, dy, dz], &plane, sides, begin, until)
}

#[inline(always)]
fn join<L: Level>(level: L, first: &[f32; 4], second: &[f32; 4]) -> L::F8 {
    level.join4(level.load4(first), level.load4(second))
}

#[inline(always)]
fn join3<L: Level>(level: L, [x, y, z]: [&[f32; 4]; 3], [x2, y2, z2]: [&[f32; 4]; 3]) -> Vec3s<L::F8> {
    [join(level, x, x2), join(level, y, y2), join(level, z, z2)]
}

/// Keeps the nearest hit among the candidates of a block, the triangles in `lanes`; whether there is one.
#[inline(always)]
fn keep<L: Level, Q: Query, const INSTANCES: bool>(
    level: L,
    slot: &mut Slot,
    inside: &mut Inside,
    block: &Block,
    lanes: u32,
    crossing: &Crossing<L::F4>,
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
    let meets = triangle::meet(&splat3(level, &[x, y, z]), &faces, crossing);
    let (tmin, tmax) = (level.splat4(slot.course.tmin), level.splat4(slot.best.t));
    let within = tmin.lt(meets.t).and(meets.t.le(tmax));
    let mut hits = within.and(meets.valid).bits() & lanes;
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
