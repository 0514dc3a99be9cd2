//! Control over a render: cancellation, counters, and finished tiles.

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

/// A flag that cancels a render. The render drops its unfinished tiles.
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

/// The frame was cancelled by [`Cancel::cancel`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Counters of the work of all threads. They only grow, over all frames that use them.
#[derive(Debug, Default)]
pub struct Counters {
    samples: AtomicU64,
    saved: AtomicU64,
    rays: AtomicU64,
    segments: AtomicU64,
    invalid: Mutex<InvalidSamples>,
}

impl Counters {
    /// The number of finished samples.
    pub fn samples(&self) -> u64 {
        self.samples.load(Ordering::Relaxed)
    }

    /// The number of finished samples, and of those that converged tiles do not need.
    pub fn settled(&self) -> u64 {
        self.samples() + self.saved.load(Ordering::Relaxed)
    }

    /// The number of traced rays, including shadow rays.
    pub fn rays(&self) -> u64 {
        self.rays.load(Ordering::Relaxed)
    }

    /// The number of path segments among these rays; the others are shadow rays.
    pub fn segments(&self) -> u64 {
        self.segments.load(Ordering::Relaxed)
    }

    /// Takes the samples that were left out since the last call, because they were NaN or infinite.
    pub fn take_invalid(&self) -> InvalidSamples {
        std::mem::take(&mut *lock(&self.invalid))
    }

    pub(super) fn add(&self, samples: u64, stats: &WaveStats) {
        self.samples.fetch_add(samples, Ordering::Relaxed);
        self.rays.fetch_add(stats.rays, Ordering::Relaxed);
        self.segments.fetch_add(stats.segments, Ordering::Relaxed);
        if stats.invalid.count > 0 {
            lock(&self.invalid).add(&stats.invalid);
        }
    }

    pub(super) fn add_saved(&self, samples: u64) {
        self.saved.fetch_add(samples, Ordering::Relaxed);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().expect("no thread panics while it holds a counter")
}

/// Receives finished tiles, on the rendering threads.
pub trait TileSink: Sync {
    /// Called when a tile has all samples of a round. It may get more in later rounds.
    fn tile(&self, tile: &TileResult<'_>);
}

/// The control over a render. The default neither observes nor cancels it.
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    pub cancel: Option<&'a Cancel>,
    pub counters: Option<&'a Counters>,
    pub sink: Option<&'a dyn TileSink>,
    /// Saves or shows the unfinished frame.
    pub interrupts: Option<&'a dyn Interrupts>,
    /// Requests the unfinished frame from a job.
    pub show: Option<&'a ShowRequest>,
    /// Receives the time that each stage takes.
    pub stages: Option<&'a StageTimes>,
}

impl Control<'_> {
    pub(super) fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(Cancel::is_cancelled)
    }
}
