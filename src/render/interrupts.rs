//! Interrupts: pauses of a frame between the blocks of its samples, in which it is kept or shown as it stands.

use std::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};

use super::tile_set::TileSet;
use crate::film::{Film, accumulator::AccumulatorLayout};

/// The wish to see the frame that renders as it stands.
#[derive(Debug, Default)]
pub struct ShowRequest(AtomicBool);

impl ShowRequest {
    pub fn ask(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    /// Whether somebody has asked and was not answered.
    pub fn is_open(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Answers the wish; whether there was one.
    pub fn take(&self) -> bool {
        self.0.swap(false, Ordering::SeqCst)
    }
}

/// Interrupts a frame.
pub trait Interrupts: Sync {
    /// Whether the frame is to pause now. All threads ask this after each block.
    fn are_due(&self) -> bool;

    /// Receives the frame as it stands, while no thread renders. It goes on afterwards, unless it was cancelled.
    fn pause(&self, frame: &PartialFrame<'_>);

    /// Whether [`PartialFrame::state`] is going to be asked for; the sums of finished tiles are kept then.
    fn keep_state(&self) -> bool;

    /// The state in which the same frame was left before.
    fn earlier_state(&self) -> Option<Vec<u8>> {
        None
    }
}

/// A frame that pauses.
pub struct PartialFrame<'a> {
    pub(super) tiles: &'a TileSet,
    pub(super) film: &'a Film,
    pub(super) layout: &'a AccumulatorLayout,
    /// The time that it has taken so far.
    pub elapsed: Duration,
    /// Whether it does not go on.
    pub is_cancelled: bool,
}

impl PartialFrame<'_> {
    /// The frame as it stands. Tiles without samples hold the backgrounds of their passes.
    pub fn film(&self) -> Film {
        let mut film = self.film.clone();
        film.samples = self.tiles.samples();
        self.tiles.resolve_into(self.layout, &mut film);
        film
    }

    /// The state as bytes, from which a later render goes on with the same bits, on any number of threads.
    pub fn state(&self) -> Vec<u8> {
        self.tiles.state(self.elapsed)
    }
}
