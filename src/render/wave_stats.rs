//! The work of a wave.

use super::InvalidSamples;

/// The work of a wave.
#[derive(Clone, Debug, Default)]
pub(super) struct WaveStats {
    pub rays: u64,
    /// The number of path segments.
    pub segments: u64,
    pub invalid: InvalidSamples,
}
