//! The memory of the process and of the machine, and the processor time.

#[cfg(not(windows))]
mod unix;
#[cfg(windows)]
mod windows;

#[cfg(not(windows))]
use unix as system;
#[cfg(windows)]
use windows as system;

pub use system::{cpu_seconds, has_limited_addresses, peak};

/// Both limits on systems that do not report their memory, in bytes.
const ELSEWHERE: u64 = 4 << 30;

/// The default of `--max-memory`, in bytes: three quarters of the free memory.
pub fn default_limit() -> u64 {
    default_limit_with(0)
}

/// The same for a job that has already taken `bytes`, which are not free any more.
pub fn default_limit_with(bytes: u64) -> u64 {
    system::free().map_or(ELSEWHERE, |free| free.saturating_add(bytes) / 4 * 3)
}

/// The default of `--texture-memory`, in bytes: half of the memory of the machine, or of what the process may use of it.
pub fn default_textures() -> u64 {
    system::total().map_or(ELSEWHERE, |bytes| bytes / 2)
}
