//! Rays in flight at leaves with triangles.
//!
//! Triangles lie in blocks of four, and vectors hold eight: two blocks are tested at once, each with its own ray.

use std::{mem::MaybeUninit, ptr};

use super::{
    super::wide::node::{Block, MAX_LEAF},
    hits,
    inflight::Inside,
    lanes::{Floats, Level, Mask},
    query::Query,
    slot::Slot,
    triangle::{self, Candidates, Crossing, each, join, join3},
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

/// A block of such a pair: twice the pair's place among them, and one more for the second block.
type Half = u8;

const _: () = assert!(MOST <= 1 << Half::BITS);

/// The blocks that rays have come to in a pass.
pub struct Visits {
    /// Where the rays' slots lie.
    slots: [usize; MOST],
    blocks: [*const Block; MOST],
    met: [MaybeUninit<Met>; MOST / 2],
    /// One more may be written than counts.
    halves: [Half; MOST + 1],
}

impl Visits {
    pub fn new() -> Self {
        Self {
            slots: [0; MOST],
            blocks: [ptr::null(); MOST],
            met: [const { MaybeUninit::uninit() }; MOST / 2],
            halves: [0; MOST + 1],
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
    unsafe fn visit<'s>(&self, slots: &'s [Slot; SLOTS], at: usize) -> (&'s Slot, &Block) {
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
        let mut pairs = 0;
        let mut at = 0;
        while at < count {
            // SAFETY: so many were added, by this function's own contract, and are in slots; each pair is found once at most.
            unsafe {
                let first = self.visit(slots, at);
                let second = self.visit(slots, at + 1);
                let Candidates { mask, crossing } = candidates(level, first, second);
                let lanes = mask.bits();
                self.met.get_unchecked_mut(pairs).write(Met {
                    at,
                    lanes,
                    crossing: crossing.to_arrays(),
                });
                pairs += usize::from(lanes != 0);
            }
            at += 2;
        }
        let mut nearer = 0;
        if Q::ANY {
            for met in &self.met[..pairs.min(MOST / 2)] {
                // SAFETY: so many were written, and what they say of was added.
                nearer |= unsafe {
                    let Met { at, lanes, crossing } = met.assume_init_ref();
                    self.decide::<L, Q, INSTANCES>(level, [*at, at + 1], *lanes, &crossing.load(level), slots, inside)
                };
            }
            return nearer;
        }
        // Of most pairs one block is met, and what follows is longer than where any hit will do: two of those at once.
        let mut halves = 0;
        for (pair, met) in self.met[..pairs.min(MOST / 2)].iter().enumerate() {
            // SAFETY: so many were written, and there are two halves of each.
            unsafe {
                let lanes = met.assume_init_ref().lanes;
                *self.halves.get_unchecked_mut(halves) = 2 * pair as Half;
                halves += usize::from(lanes & 0b1111 != 0);
                *self.halves.get_unchecked_mut(halves) = 2 * pair as Half + 1;
                halves += usize::from(lanes > 0b1111);
            }
        }
        if halves % 2 == 1 {
            // Here as well the last one twice: what is kept already is not nearer.
            self.halves[halves % MOST] = self.halves[halves - 1];
        }
        let mut next = 0;
        while next < halves {
            // SAFETY: so many were written, and what they say of was as well.
            nearer |= unsafe {
                let (first, i) = self.half(*self.halves.get_unchecked(next));
                let (second, j) = self.half(*self.halves.get_unchecked(next + 1));
                let lanes = first.lanes >> (4 * i) & 0b1111 | second.lanes >> (4 * j) << 4;
                let crossing = Crossing::join(level, [&first.crossing, &second.crossing], [i, j]);
                self.decide::<L, Q, INSTANCES>(level, [first.at + i, second.at + j], lanes, &crossing, slots, inside)
            };
            next += 2;
        }
        nearer
    }

    /// # Safety
    /// There is such a half of a pair that was written.
    #[inline(always)]
    unsafe fn half(&self, half: Half) -> (&Met, usize) {
        let (pair, half) = (usize::from(half / 2), usize::from(half % 2));
        // SAFETY: by this function's own contract.
        (unsafe { self.met.get_unchecked(pair).assume_init_ref() }, half)
    }

    /// Keeps what of two blocks in the list is hit among these `lanes`; the set of slots of whose rays that is.
    ///
    /// # Safety
    /// The blocks were added, and still exist.
    #[inline(always)]
    unsafe fn decide<L: Level, Q: Query, const INSTANCES: bool>(
        &self,
        level: L,
        at: [usize; 2],
        lanes: u32,
        crossing: &Crossing<L::F8>,
        slots: &mut [Slot; SLOTS],
        inside: &mut [Inside; SLOTS],
    ) -> u64 {
        // SAFETY: by this function's own contract.
        let [first, second] = unsafe { [self.visit(slots, at[0]), self.visit(slots, at[1])] };
        let hits = hits::decide::<L, Q>(level, [first, second], lanes, crossing);
        let (a, b) = (number(slots, first.0), number(slots, second.0));
        let blocks = [first.1, second.1];
        let first = hits::keep::<Q, INSTANCES>(&hits, 0, &mut slots[a], &mut inside[a], blocks[0]);
        let second = hits::keep::<Q, INSTANCES>(&hits, 1, &mut slots[b], &mut inside[b], blocks[1]);
        u64::from(first) << a | u64::from(second) << b
    }
}

/// Which of the `slots` it is.
#[inline(always)]
fn number(slots: &[Slot; SLOTS], slot: &Slot) -> usize {
    (ptr::from_ref(slot).addr() - slots.as_ptr().addr()) / size_of::<Slot>() % SLOTS
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
