//! The stacks of what goes through a tree, all in one piece of memory.

use std::marker::PhantomData;

use super::slot_set::SLOTS;
use crate::{accel::wide::node::DONE, simd::lanes::Top};

/// Entries of a stack in a cache line.
const LINE: usize = 16;

/// Of a stack's entries the first and what is behind it end a cache line, so that stores of eight seldom lie in two: that
/// takes twice as long, and all rays together need more of the first cache. What is behind says that the ray is done.
const BASE: usize = 1;

/// Popping may look at seven more, in which it finds nothing before.
const MORE: usize = 7;

/// A cache line of either.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct StackLine<T>([T; LINE]);

/// Where stacks begin and end in [`Stacks`]. They grow towards smaller places.
#[repr(C)]
#[derive(Clone, Default)]
pub struct StackRange {
    /// Where the next child goes.
    pub top: u32,
    /// Where the first one goes, or went.
    base: u32,
}

impl StackRange {
    /// Takes everything off.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.top = self.base;
    }

    /// Where the next child goes, and the first one.
    #[inline(always)]
    pub fn places(&self) -> (usize, usize) {
        (self.top as usize, self.base as usize)
    }
}

/// The memory of the stacks, a stack for each slot.
pub struct StackMemory {
    /// Where children on the stacks are entered, then the children: `stride` lines of each for every slot.
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

    /// Makes room for stacks of `len` entries and marks their ends. Whether they lie elsewhere now: then what has a
    /// stack needs its [`StackMemory::of_slot`] anew.
    pub fn reserve(&mut self, len: usize) -> bool {
        // An odd number of cache lines, so that the ends of all stacks do not share a few sets of the cache.
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

    /// The empty stack of a slot.
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

/// The stacks of all slots, behind one another; [`StackRange`] say where. Entries are read and written without a check.
#[derive(Clone, Copy)]
pub struct Stacks<'m> {
    enter: *mut f32,
    child: *mut u32,
    memory: PhantomData<&'m mut StackMemory>,
}

impl<'m> Stacks<'m> {
    /// The child in a place.
    ///
    /// # Safety
    /// The place is one of these stacks'.
    #[inline(always)]
    pub unsafe fn child(self, at: usize) -> u32 {
        // SAFETY: by this function's own contract.
        unsafe { *self.child.add(at) }
    }

    /// Where the children in a place and in the seven after it are entered.
    ///
    /// # Safety
    /// So are these places.
    #[inline(always)]
    pub unsafe fn enter8(self, at: usize) -> [f32; 8] {
        // SAFETY: by this function's own contract.
        unsafe { *self.enter.add(at).cast() }
    }

    /// The children in a place and in the seven after it.
    ///
    /// # Safety
    /// So are these places.
    #[inline(always)]
    pub unsafe fn child8(self, at: usize) -> [u32; 8] {
        // SAFETY: by this function's own contract.
        unsafe { *self.child.add(at).cast() }
    }

    /// Writes a place.
    ///
    /// # Safety
    /// The place is one of these stacks'.
    #[inline(always)]
    pub unsafe fn set(self, at: usize, enter: f32, child: u32) {
        // SAFETY: by this function's own contract.
        unsafe {
            *self.enter.add(at) = enter;
            *self.child.add(at) = child;
        }
    }

    /// Room for a store of eight that ends in a place.
    ///
    /// # Safety
    /// The place and the seven before it are one stack's, and nothing else is borrowed of it.
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
