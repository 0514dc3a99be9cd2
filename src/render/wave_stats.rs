//! The work of a wave.

use super::InvalidSamples;

/// The work of a wave.
#[derive(Clone, Debug, Default)]
pub(super) struct WaveStats {
    pub rays: u64,
    /// The rays that were traced to their nearest hit for a path.
    pub segments: u64,
    pub invalid: InvalidSamples,
}
