//! The largest pictures that are decoded.

use super::error::ImageProblem;

/// The longest side, in pixels.
pub(super) const MAX_SIDE: u32 = 1 << 16;
/// The most bytes of a decoded picture.
pub(super) const MAX_BYTES: u64 = 4 << 30;

/// Refuses empty and absurd pictures before memory is allocated.
pub(super) fn check_size([width, height]: [u64; 2], bytes: u64) -> Result<(), ImageProblem> {
    let side = u64::from(MAX_SIDE);
    if width == 0 || height == 0 || width > side || height > side || bytes > MAX_BYTES {
        return Err(ImageProblem::Size { width, height });
    }
    Ok(())
}

/// The bytes of a picture after some halvings of its size.
pub(super) fn shrunk(bytes: u64, halvings: u32) -> u64 {
    bytes >> (2 * halvings).min(63)
}

/// The bytes of a picture with all its mipmap levels; `number` is the size of a channel of the picture in bytes; a
/// channel of a level takes at least 2.
pub(super) fn with_levels(bytes: u64, number: u64) -> u64 {
    bytes.saturating_add(bytes / 3 * if number == 1 { 2 } else { 1 })
}
