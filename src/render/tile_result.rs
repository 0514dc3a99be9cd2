//! The finished tiles that a sink receives.

use std::ops::Range;

use crate::film::{AccumulatorLayout, Film, TileAccumulator, Window};

/// A tile that has all samples of a round.
pub struct TileResult<'a> {
    pub(super) accumulator: &'a TileAccumulator,
    pub(super) layout: &'a AccumulatorLayout,
    pub(super) window: Window,
    /// The samples of the round. A converged tile has fewer.
    pub samples: Range<u32>,
}

impl TileResult<'_> {
    /// The pixels of the tile within the frame's window.
    pub fn tile(&self) -> Window {
        self.accumulator.tile().intersection(self.window)
    }

    /// Writes the tile's current pixels into a film of the frame's layout.
    pub fn resolve_into(&self, film: &mut Film) {
        self.accumulator.resolve_into(self.layout, film);
    }
}
