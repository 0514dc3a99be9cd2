//! Control over a render: cancelling, counters, and tiles as they get ready.

use std::sync::{
    Mutex, MutexGuard,
    atomic::{AtomicBool, AtomicU64, Ordering},
};

use super::{
    InvalidSamples, TileResult,
    interrupts::{Interrupts, ShowRequest},
    wave_stats::WaveStats,
};
use crate::integrator::StageTimes;

/// The word to stop. A render that sees it leaves its unfinished tiles.
#[derive(Debug, Default)]
pub struct Cancel(AtomicBool);

impl Cancel {
    pub fn cancel(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The frame was given up because of [`Cancel::cancel`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Counts of the work that all threads have done. They only rise, over all frames that they are given to.
#[derive(Debug, Default)]
pub struct Counters {
    samples: AtomicU64,
    saved: AtomicU64,
    rays: AtomicU64,
    segments: AtomicU64,
    invalid: Mutex<InvalidSamples>,
}

impl Counters {
    /// The samples that are finished.
    pub fn samples(&self) -> u64 {
        self.samples.load(Ordering::Relaxed)
    }

    /// The samples that are finished, and those that tiles need not have because their noise is low.
    pub fn settled(&self) -> u64 {
        self.samples() + self.saved.load(Ordering::Relaxed)
    }

    /// The rays that were traced, for nearest hits and for shadows.
    pub fn rays(&self) -> u64 {
        self.rays.load(Ordering::Relaxed)
    }

    /// The segments of paths among these rays; the others are shadow rays.
    pub fn segments(&self) -> u64 {
        self.segments.load(Ordering::Relaxed)
    }

    /// Takes the samples that were left out since the last call because they were NaN or infinite.
    pub fn take_invalid(&self) -> InvalidSamples {
        std::mem::take(&mut *lock(&self.invalid))
    }

    pub(super) fn add(&self, samples: u64, stats: &WaveStats) {
        self.samples.fetch_add(samples, Ordering::Relaxed);
        self.rays.fetch_add(stats.rays, Ordering::Relaxed);
        self.segments.fetch_add(stats.segments, Ordering::Relaxed);
    }

    pub(super) fn add_saved(&self, samples: u64) {
        self.saved.fetch_add(samples, Ordering::Relaxed);
    }

    pub(super) fn add_invalid(&self, invalid: &InvalidSamples) {
        if invalid.count > 0 {
            lock(&self.invalid).add(invalid);
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().expect("no thread panics while it holds a counter")
}

/// Receives tiles as they get ready, on the threads that render.
pub trait TileSink: Sync {
    /// A tile has all samples of a round. It may get more in later rounds.
    fn tile(&self, tile: &TileResult<'_>);
}

/// The control over a render. By default it is neither watched nor cancelled.
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    pub cancel: Option<&'a Cancel>,
    pub counters: Option<&'a Counters>,
    pub sink: Option<&'a dyn TileSink>,
    /// Keeps the frame, or shows it as it stands.
    pub interrupts: Option<&'a dyn Interrupts>,
    /// Asks a job for the frame as it stands.
    pub show: Option<&'a ShowRequest>,
    /// Receives the time that each stage takes.
    pub stages: Option<&'a StageTimes>,
}

impl Control<'_> {
    pub(super) fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(Cancel::is_cancelled)
    }
}
