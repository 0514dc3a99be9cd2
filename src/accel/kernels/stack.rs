//! The traversal stacks, all in one allocation.

use std::marker::PhantomData;

use super::slot_set::SLOTS;
use crate::{accel::wide::node::DONE, simd::lanes::Top};

/// The number of stack entries in a cache line.
const LINE: usize = 16;

/// The number of entries after a stack's base. They end a cache line, so that stores of eight
/// entries seldom straddle two lines. A straddling store takes twice as long and occupies more of
/// the L1 cache. The entry after the base is the end marker.
const BASE: usize = 1;

/// The number of further entries that popping may read; they are always nearer than anything.
const MORE: usize = 7;

/// A cache line of distances or of children.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct StackLine<T>([T; LINE]);

/// The range of a stack in [`Stacks`]. Stacks grow towards lower places.
#[repr(C)]
#[derive(Clone, Default)]
pub struct StackRange {
    /// The place of the next child.
    pub top: u32,
    /// The place of the first child.
    base: u32,
}

impl StackRange {
    /// Removes all children.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.top = self.base;
    }

    /// Returns the places of the next child and of the first one.
    #[inline(always)]
    pub fn places(&self) -> (usize, usize) {
        (self.top as usize, self.base as usize)
    }
}

/// The memory of the stacks, one for each slot.
pub struct StackMemory {
    /// The entry distances of the children on the stacks, then the children: `stride` lines of each
    /// per slot.
    enter: Vec<StackLine<f32>>,
    child: Vec<StackLine<u32>>,
    /// In cache lines.
    stride: usize,
}

impl StackMemory {
    pub const fn new() -> Self {
        Self {
            enter: Vec::new(),
            child: Vec::new(),
            stride: 0,
        }
    }

    /// Reserves stacks of `len` entries and writes their end markers. Returns whether the layout
    /// has changed; then every slot needs a new [`StackMemory::of_slot`].
    pub fn reserve(&mut self, len: usize) -> bool {
        // An odd number of cache lines, so that the ends of the stacks are not in the same few sets
        // of the cache.
        let stride = (BASE + len).div_ceil(LINE) | 1;
        let grows = self.stride < stride;
        if grows {
            self.stride = stride;
            let lines = SLOTS * stride + MORE.div_ceil(LINE);
            self.enter = vec![StackLine([f32::NEG_INFINITY; LINE]); lines];
            self.child = vec![StackLine([DONE; LINE]); lines];
        }
        grows
    }

    /// Returns the empty stack of a slot.
    pub fn of_slot(&self, id: usize) -> StackRange {
        let base = ((id + 1) * self.stride * LINE - BASE - 1) as u32;
        StackRange { top: base, base }
    }

    pub fn stacks(&mut self) -> Stacks<'_> {
        Stacks {
            enter: self.enter.as_mut_ptr().cast(),
            child: self.child.as_mut_ptr().cast(),
            memory: PhantomData,
        }
    }
}

/// The stacks of all slots; each [`StackRange`] is a part of them. Accesses are not bounds-checked.
#[derive(Clone, Copy)]
pub struct Stacks<'m> {
    enter: *mut f32,
    child: *mut u32,
    memory: PhantomData<&'m mut StackMemory>,
}

impl<'m> Stacks<'m> {
    /// Returns the child at a place.
    ///
    /// # Safety
    /// The place belongs to one of these stacks.
    #[inline(always)]
    pub unsafe fn child(self, at: usize) -> u32 {
        // SAFETY: by this function's own contract.
        unsafe { *self.child.add(at) }
    }

    /// Returns the entry distances at a place and the seven after it.
    ///
    /// # Safety
    /// The places belong to these stacks.
    #[inline(always)]
    pub unsafe fn enter8(self, at: usize) -> [f32; 8] {
        // SAFETY: by this function's own contract.
        unsafe { *self.enter.add(at).cast() }
    }

    /// Returns the children at a place and the seven after it.
    ///
    /// # Safety
    /// The places belong to these stacks.
    #[inline(always)]
    pub unsafe fn child8(self, at: usize) -> [u32; 8] {
        // SAFETY: by this function's own contract.
        unsafe { *self.child.add(at).cast() }
    }

    /// Writes an entry.
    ///
    /// # Safety
    /// The place belongs to one of these stacks.
    #[inline(always)]
    pub unsafe fn set(self, at: usize, enter: f32, child: u32) {
        // SAFETY: by this function's own contract.
        unsafe {
            *self.enter.add(at) = enter;
            *self.child.add(at) = child;
        }
    }

    /// Returns the memory for a store of eight entries that ends at a place.
    ///
    /// # Safety
    /// The place and the seven before it belong to one stack, which has no other borrow.
    #[inline(always)]
    pub unsafe fn top(self, last: usize) -> Top<'m> {
        // SAFETY: by this function's own contract.
        unsafe {
            Top {
                enter: &mut *self.enter.add(last).sub(7).cast(),
                child: &mut *self.child.add(last).sub(7).cast(),
            }
        }
    }
}
