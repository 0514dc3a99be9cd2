//! Which rays in flight wait for what: sets of slots, a bit for each.

/// Rays in flight, as many as a set has bits.
pub const SLOTS: usize = 64;

/// Takes the lowest member from a set that is not empty.
#[inline(always)]
pub fn pop_lowest(set: &mut u64) -> usize {
    let id = set.trailing_zeros() as usize % SLOTS;
    *set &= *set - 1;
    id
}
