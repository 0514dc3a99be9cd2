//! Intersection of the stream's rays with the triangles of leaves.
//!
//! Blocks have four triangles and vectors eight lanes, so two blocks are tested at once, each with
//! its own ray.

use std::{
    mem::{MaybeUninit, offset_of},
    ptr,
};

use super::{
    aliased_buffer::AliasedBuffer,
    hits,
    query::Query,
    ray_state::{InstanceState, RayState},
    slot_set::SLOTS,
    triangle::{self, Candidates, Crossing, each, join, join3},
};
use crate::{
    accel::wide::node::{MAX_LEAF, TriangleBlock},
    simd::{
        huge_pages::PAGE,
        lanes::{Floats, Mask, SimdLevel},
    },
};

/// The largest number of blocks that the rays of a pass can visit.
const MAX_VISITS: usize = SLOTS * MAX_LEAF;

/// A pair of blocks with at least one candidate for a hit.
#[repr(align(64))]
struct CandidatePair {
    /// The position of the pair in the queue.
    at: usize,
    /// The set of candidates.
    lanes: u32,
    crossing: Crossing<[f32; 8]>,
}

/// The blocks that rays visit in a pass. Elements beyond the current count are uninitialised.
///
/// The beginnings of the three lists occupy consecutive parts of a page; see
/// [`super::aliased_buffer`].
#[repr(C)]
pub struct LeafQueue {
    /// The addresses of the rays' slots. One element beyond the count may be written; the same
    /// holds for the blocks.
    slots: [MaybeUninit<usize>; MAX_VISITS + 1],
    _before_blocks: [MaybeUninit<u8>; BEFORE_BLOCKS],
    blocks: [MaybeUninit<*const TriangleBlock>; MAX_VISITS + 1],
    _before_met: [MaybeUninit<u8>; BEFORE_MET],
    met: [MaybeUninit<CandidatePair>; MAX_VISITS / 2],
}

/// The numbers of blocks, and of pairs with candidates, that most passes do not exceed.
const USUAL_VISITS: usize = 48;
const USUAL_MET: usize = 4;

/// The positions in a page at which the lists end in most passes.
const SLOTS_END: usize = USUAL_VISITS * size_of::<usize>();
const BLOCKS_END: usize = SLOTS_END + USUAL_VISITS * size_of::<*const TriangleBlock>();
const MET_END: usize = BLOCKS_END + USUAL_MET * size_of::<CandidatePair>();

const BEFORE_BLOCKS: usize = up_to(SLOTS_END, size_of::<[usize; MAX_VISITS + 1]>());
const BEFORE_MET: usize = up_to(BLOCKS_END, SLOTS_END + size_of::<[usize; MAX_VISITS + 1]>());

/// Returns the distance from an address to the next one at the position `part` of a page.
const fn up_to(part: usize, from: usize) -> usize {
    (part + PAGE - from % PAGE) % PAGE
}

const _: () =
    assert!(offset_of!(LeafQueue, blocks) % PAGE == SLOTS_END && offset_of!(LeafQueue, met) % PAGE == BLOCKS_END);

impl LeafQueue {
    /// Returns the queue for a kernel that has `local` in its stack frame.
    pub fn opposite<'r, F>(room: &'r mut AliasedBuffer<Self>, local: &F) -> &'r mut Self {
        // SAFETY: all fields may be uninitialised.
        unsafe { room.opposite(local, MET_END).assume_init_mut() }
    }

    /// Adds the blocks of a leaf after the first `count`, and returns the new count. `slot` is the
    /// address of the ray's slot.
    ///
    /// # Safety
    /// The slot exists, and each slot has at most one leaf. A leaf has at most [`MAX_LEAF`] blocks.
    #[inline(always)]
    pub unsafe fn add<L: SimdLevel>(
        &mut self,
        level: L,
        mut count: usize,
        slot: usize,
        blocks: &[TriangleBlock],
    ) -> usize {
        let first = blocks.as_ptr();
        level.prefetch::<3>(first.cast());
        // A second block is unpredictable, so it is always written; more than two are rare.
        // SAFETY: there is room for all blocks that the leaves of all slots can have, and for one
        // more.
        unsafe {
            self.put(count, slot, first);
            self.put(count + 1, slot, first.wrapping_add(1));
        }
        for block in blocks.iter().skip(2) {
            count += 1;
            // SAFETY: as above.
            unsafe { self.put(count + 1, slot, block) };
        }
        count + blocks.len().min(2)
    }

    /// # Safety
    /// `at` is at most [`MAX_VISITS`].
    #[inline(always)]
    unsafe fn put(&mut self, at: usize, slot: usize, block: *const TriangleBlock) {
        debug_assert!(at <= MAX_VISITS);
        // SAFETY: by this function's own contract.
        unsafe {
            self.slots.get_unchecked_mut(at).write(slot);
            self.blocks.get_unchecked_mut(at).write(block);
        }
    }

    /// Returns a block and the slot whose ray visits it.
    ///
    /// # Safety
    /// The block was added at this position, for one of `slots`, and still exists.
    #[inline(always)]
    unsafe fn visit<'s>(&self, slots: &'s [RayState; SLOTS], at: usize) -> (&'s RayState, &TriangleBlock) {
        // SAFETY: by this function's own contract.
        unsafe {
            let slot = slots.as_ptr().with_addr(self.slots.get_unchecked(at).assume_init());
            (&*slot, &*self.blocks.get_unchecked(at).assume_init())
        }
    }

    /// Tests the `count` blocks in the queue. Returns the set of slots whose rays were shortened or
    /// blocked.
    ///
    /// # Safety
    /// Exactly `count` blocks were added, and all still exist.
    #[inline(always)]
    pub unsafe fn test<L: SimdLevel, Q: Query, const INSTANCES: bool>(
        &mut self,
        level: L,
        count: usize,
        slots: &mut [RayState; SLOTS],
        inside: &mut [InstanceState; SLOTS],
    ) -> u64 {
        if count % 2 == 1 {
            // The last block is repeated. There is room for it, since the capacity is even.
            (self.slots[count % MAX_VISITS], self.blocks[count % MAX_VISITS]) =
                (self.slots[count - 1], self.blocks[count - 1]);
        }
        // Hits are unpredictable, so pairs with candidates are first collected without a branch.
        let mut pairs = 0;
        let mut at = 0;
        while at < count {
            // SAFETY: by this function's own contract, the blocks were added and their slots exist;
            // each pair is written at most once.
            unsafe {
                let first = self.visit(slots, at);
                let second = self.visit(slots, at + 1);
                let Candidates { mask, crossing } = candidates(level, first, second);
                let lanes = mask.bits();
                self.met.get_unchecked_mut(pairs).write(CandidatePair {
                    at,
                    lanes,
                    crossing: crossing.to_arrays(),
                });
                pairs += usize::from(lanes != 0);
            }
            at += 2;
        }
        let mut nearer = 0;
        for met in &self.met[..pairs.min(MAX_VISITS / 2)] {
            // SAFETY: these elements were written.
            let CandidatePair {
                at,
                mut lanes,
                ref crossing,
            } = *unsafe { met.assume_init_ref() };
            loop {
                let lane = lanes.trailing_zeros() as usize % 8;
                lanes &= lanes - 1;
                // SAFETY: the blocks of a pair were added.
                let (slot, block) = unsafe { self.visit(slots, at + lane / 4) };
                let meet = hits::meet::<L, Q>(level, slot, block, lane % 4, &crossing.spread(level, lane));
                let id = number(slots, slot);
                let is_nearer =
                    hits::keep::<Q, INSTANCES>(&meet, block.keys[lane % 4], &mut slots[id], &mut inside[id]);
                nearer |= u64::from(is_nearer) << id;
                if lanes == 0 {
                    break;
                }
            }
        }
        nearer
    }
}

/// Returns the index of a slot.
#[inline(always)]
fn number(slots: &[RayState; SLOTS], slot: &RayState) -> usize {
    (ptr::from_ref(slot).addr() - slots.as_ptr().addr()) / size_of::<RayState>() % SLOTS
}

/// Returns the candidates among the triangles of two blocks for the rays of two slots. The first
/// half of the lanes is that of the first block.
#[inline(always)]
fn candidates<L: SimdLevel>(
    level: L,
    first: (&RayState, &TriangleBlock),
    second: (&RayState, &TriangleBlock),
) -> Candidates<L::F8> {
    let ([o, d, shear], [o2, d2, shear2]) = (first.0.line(), second.0.line());
    let [x, y, z, begin] = level.quads(join(level, o, o2));
    let [dx, dy, dz, until] = level.quads(join(level, d, d2));
    let [sx, sy, ..] = level.quads(join(level, shear, shear2));
    let ([a, b, c], [a2, b2, c2]) = (
        first.0.permute_axes(&first.1.corners),
        second.0.permute_axes(&second.1.corners),
    );
    let corners = [
        each(join3(level, a, a2), [x, y, z], L::F8::sub),
        each(join3(level, b, b2), [x, y, z], L::F8::sub),
        each(join3(level, c, c2), [x, y, z], L::F8::sub),
    ];
    let sides = triangle::sides(&corners, [sx, sy]);
    // Often the line intersects one of the triangles, but seldom between the ray's ends. One
    // predictable branch is faster than two.
    let plane = triangle::plane(&corners);
    triangle::candidates([dx, dy, dz], &plane, sides, begin, until)
}
