//! A buffer at a chosen position in a page, to avoid false dependencies between stores and loads.
//!
//! A processor compares the lowest bits of addresses to find out whether a load reads memory that
//! was just written. If they agree, it delays the load until it knows better. The lowest twelve
//! bits agree if both addresses have the same position in a page. Some processors also compare the
//! next four bits, which depend on the pages that the system happens to provide. So a kernel's
//! buffer and its stack frame, which it writes and reads in every iteration, get different
//! positions in a page.
//!
//! The comparison of the position in a page is described in AMD, "Software Optimization Guide for
//! AMD64 Processors", 25112, 2005, section 5.5, "False Dependencies". The comparison of the next
//! four bits was found by measurement (docs/notes/acceleration.md, "Memory").

use std::{marker::PhantomData, mem::MaybeUninit, ptr};

use crate::simd::huge_pages::PAGE;

/// A cache line.
#[repr(C, align(64))]
struct CacheLine([u8; LINE]);

const LINE: usize = 64;

/// Memory for a `T` that can begin at any cache line of a page.
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

    /// Returns the memory whose first `length` bytes are as far as possible from `local` in a page.
    /// `local` is in the caller's frame.
    pub fn opposite<F>(&mut self, local: &F, length: usize) -> &mut MaybeUninit<T> {
        // Only the position in a page is used, so addresses cannot overflow.
        let middle = ptr::from_ref(local).addr() % PAGE + size_of::<F>() / 2 + PAGE / 2;
        let line = middle.wrapping_sub(length / 2).wrapping_sub(self.lines.as_ptr().addr()) % PAGE / LINE;
        let lines = &mut self.lines[line..line + Self::LINES];
        // SAFETY: the lines are at least as large as the value and at least as aligned; the value
        // may be uninitialised.
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
