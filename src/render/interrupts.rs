//! Interrupts: pauses of a frame between blocks of samples, in which the unfinished frame is saved or shown, and its end.

use std::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};

use super::{SampleBudget, tile_set::TileSet};
use crate::film::{AccumulatorLayout, Film};

/// A request for the unfinished frame.
#[derive(Debug, Default)]
pub struct ShowRequest(AtomicBool);

impl ShowRequest {
    pub fn ask(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    /// Whether there is an unanswered request.
    pub fn is_open(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Removes the request; returns whether there was one.
    pub fn take(&self) -> bool {
        self.0.swap(false, Ordering::SeqCst)
    }
}

/// Interrupts a frame.
pub trait Interrupts: Sync {
    /// Whether the frame must pause now. All threads call this after each block.
    fn are_due(&self) -> bool;

    /// Receives the unfinished frame while no thread renders. Rendering continues afterwards unless it was cancelled.
    fn pause(&self, frame: &PartialFrame<'_>);

    /// Whether [`PartialFrame::state`] will be called; then the accumulators of finished tiles are kept.
    fn keep_state(&self) -> bool;

    /// The state of an earlier render of the same frame, which was unfinished or had fewer samples, or of the range of its
    /// samples with this number from 0.
    fn earlier_state(&self, _range: Option<u32>) -> Option<Vec<u8>> {
        None
    }

    /// Is told that samples cannot be added to those of [`earlier_state`](Self::earlier_state) as one render adds them, so
    /// that the frame starts without them.
    fn earlier_state_is_left(&self) {}

    /// Receives the frame with all its samples, if it [keeps the state](Self::keep_state).
    fn finished(&self, _frame: &PartialFrame<'_>) {}
}

/// A paused frame.
pub struct PartialFrame<'a> {
    pub(super) tiles: &'a TileSet,
    pub(super) film: &'a Film,
    pub(super) layout: &'a AccumulatorLayout,
    pub(super) budget: &'a SampleBudget,
    /// The rendering time so far.
    pub elapsed: Duration,
    /// Whether rendering does not continue.
    pub is_cancelled: bool,
}

impl PartialFrame<'_> {
    /// The unfinished frame. Tiles without samples have the background values of their passes.
    pub fn film(&self) -> Film {
        let mut film = self.film.clone();
        film.samples = self.tiles.samples();
        self.tiles.resolve_into(self.layout, &mut film);
        film
    }

    /// The state as bytes, from which a later render continues with the same bits on any number of threads.
    pub fn state(&self) -> Vec<u8> {
        self.tiles.state(self.budget, self.elapsed)
    }
}
