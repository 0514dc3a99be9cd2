//! The state of accumulators as bytes, for checkpoints.
//!
//! Numbers are in the byte order of this machine. The bytes do not describe their layout; the caller must use the same one.

use bytemuck::{Pod, bytes_of, bytes_of_mut, cast_slice, cast_slice_mut};

/// Appends numbers, whose count the reader knows.
pub(super) fn put<T: Pod>(out: &mut Vec<u8>, values: &[T]) {
    out.extend_from_slice(cast_slice(values));
}

/// Appends numbers with their count.
pub(super) fn put_counted<T: Pod>(out: &mut Vec<u8>, values: &[T]) {
    out.extend_from_slice(bytes_of(&(values.len() as u64)));
    put(out, values);
}

/// Reads `values` from the start of `input`, and advances it. `None` if it is too short.
pub(super) fn take<T: Pod>(input: &mut &[u8], values: &mut [T]) -> Option<()> {
    let (bytes, rest) = input.split_at_checked(size_of_val(values))?;
    cast_slice_mut::<T, u8>(values).copy_from_slice(bytes);
    *input = rest;
    Some(())
}

/// Reads numbers that were written with their count.
pub(super) fn take_counted<T: Pod>(input: &mut &[u8]) -> Option<Vec<T>> {
    let mut count = 0_u64;
    let (bytes, rest) = input.split_at_checked(size_of::<u64>())?;
    bytes_of_mut(&mut count).copy_from_slice(bytes);
    let count = usize::try_from(count).ok()?;
    if count.checked_mul(size_of::<T>())? > rest.len() {
        return None;
    }
    *input = rest;
    let mut values = vec![T::zeroed(); count];
    take(input, &mut values)?;
    Some(values)
}
