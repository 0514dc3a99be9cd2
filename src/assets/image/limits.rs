//! The largest pictures that are decoded.

use super::error::ImageProblem;

/// The longest side that is decoded, in pixels.
pub(super) const MAX_SIDE: u32 = 1 << 16;
/// The most that a decoded picture may take, in bytes.
pub(super) const MAX_BYTES: u64 = 4 << 30;

/// Refuses empty and absurd pictures before memory is allocated.
pub(super) fn check_size([width, height]: [u64; 2], bytes: u64) -> Result<(), ImageProblem> {
    let side = u64::from(MAX_SIDE);
    if width == 0 || height == 0 || width > side || height > side || bytes > MAX_BYTES {
        return Err(ImageProblem::Size { width, height });
    }
    Ok(())
}

/// The bytes of a picture whose size is halved.
pub(super) fn shrunk(bytes: u64, halvings: u32) -> u64 {
    bytes >> (2 * halvings).min(63)
}

/// The bytes of a picture with all its smaller levels, each a quarter of the one before.
pub(super) fn with_levels(bytes: u64) -> u64 {
    bytes.saturating_add(bytes / 3)
}
