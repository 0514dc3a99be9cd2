//! Sets of slots, one bit each.

/// The number of slots, one for each active ray of a stream: as many as a set has bits.
pub const SLOTS: usize = 64;

/// Removes the lowest slot from a set that is not empty.
#[inline(always)]
pub fn pop_lowest(set: &mut u64) -> usize {
    let id = set.trailing_zeros() as usize % SLOTS;
    *set &= *set - 1;
    id
}
