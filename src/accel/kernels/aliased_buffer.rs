//! Memory that keeps clear of a kernel's frame.
//!
//! A processor finds out by the lowest bits of addresses whether what it reads was written just before. Where these agree it holds
//! back what is read until it knows better: where the lowest twelve do, which is where both lie at the same place of a page, and some
//! once more where the next four do as well, which depends on the pages that the system happened to give. So what a kernel
//! writes in every turn lies elsewhere in a page than what it reads then: its own frame, and the rest of such memory.
//!
//! That it is the place in a page which decides first: AMD, "Software Optimization Guide for AMD64 Processors", 25112, 2005, section 5.5,
//! "False Dependencies"; the next four bits are measured (docs/notes/acceleration.md, "Memory").

use std::{marker::PhantomData, mem::MaybeUninit, ptr};

use crate::simd::huge_pages::PAGE;

/// A cache line.
#[repr(C, align(64))]
struct CacheLine([u8; LINE]);

const LINE: usize = 64;

/// Room for a `T`, beginning at any cache line of a page.
pub struct AliasedBuffer<T> {
    lines: Box<[MaybeUninit<CacheLine>]>,
    what: PhantomData<T>,
}

impl<T> AliasedBuffer<T> {
    const LINES: usize = size_of::<T>().div_ceil(LINE);

    pub fn new() -> Self {
        const { assert!(align_of::<T>() <= LINE) };
        Self {
            lines: Box::new_uninit_slice(Self::LINES + PAGE / LINE - 1),
            what: PhantomData,
        }
    }

    /// Where its first `length` bytes lie opposite to `local` in a page, which is in the frame of the kernel that asks.
    pub fn opposite<F>(&mut self, local: &F, length: usize) -> &mut MaybeUninit<T> {
        // Of a place in a page alone, so that nothing comes of an address at the end of all.
        let middle = ptr::from_ref(local).addr() % PAGE + size_of::<F>() / 2 + PAGE / 2;
        let line = middle.wrapping_sub(length / 2).wrapping_sub(self.lines.as_ptr().addr()) % PAGE / LINE;
        let lines = &mut self.lines[line..line + Self::LINES];
        // SAFETY: so many lines are as long as the value or longer, and aligned as it is or more; nothing is said of what is in them.
        unsafe { &mut *lines.as_mut_ptr().cast() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_used_most_lies_opposite_to_a_local_wherever_that_is() {
        let mut room = AliasedBuffer::<[u64; 700]>::new();
        let page = [0_u64; 2 * PAGE / 8];
        for local in &page {
            for length in [64, 1536] {
                let value = room.opposite(local, length);
                let at = ptr::from_mut(value).addr();
                let to = (at + length / 2).wrapping_sub(ptr::from_ref(local).addr()) % PAGE;
                assert!(at.is_multiple_of(LINE) && to.abs_diff(PAGE / 2) <= LINE, "{to}");
                value.write([u64::MAX; 700]);
            }
        }
    }
}
