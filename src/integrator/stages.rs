//! The stages of rendering, and a clock that measures their times.
//!
//! The clock is read once per stage of a batch of vertices, and around the light of each vertex, where its own time of about
//! 25 ns shows. It does nothing if no times are wanted. Processor time takes ten times as long to read, so it is read once a wave
//! and divided among the stages in proportion to wall-clock time.

use std::{
    sync::atomic::{AtomicU64, Ordering},
    time::{Duration, Instant},
};

use cpu_time::ThreadTime;

/// A stage of rendering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    CameraRays,
    /// The nearest hits of camera rays and of continued paths.
    Nearest,
    /// The surface interactions at hits.
    Surfaces,
    /// The random numbers.
    Numbers,
    /// The light of rays that hit nothing.
    Background,
    /// The choice of lights and of points on them.
    Light,
    /// Emission of surfaces, textures, and the evaluation and sampling of BSDFs.
    Bsdf,
    Shadow,
    /// Sums of samples to pixels.
    Film,
}

impl Stage {
    /// All stages and their names, in the order of the work.
    pub const TABLE: [(Self, &str); 9] = [
        (Self::CameraRays, "camera rays"),
        (Self::Nearest, "nearest"),
        (Self::Surfaces, "surfaces"),
        (Self::Numbers, "numbers"),
        (Self::Background, "background"),
        (Self::Light, "light"),
        (Self::Bsdf, "bsdf"),
        (Self::Shadow, "shadow"),
        (Self::Film, "film"),
    ];
}

/// A stopwatch of one thread.
#[derive(Clone, Debug, Default)]
pub(crate) struct StageClock {
    last: Option<Instant>,
    /// The thread's processor time at the start.
    cpu: Option<Duration>,
    /// Wall-clock time.
    spent: [Duration; Stage::TABLE.len()],
}

impl StageClock {
    /// Starts the clock if `measures`; otherwise it measures nothing.
    pub fn start(&mut self, measures: bool) {
        *self = Self {
            cpu: measures.then(|| ThreadTime::now().as_duration()),
            last: measures.then(Instant::now),
            ..Self::default()
        };
    }

    /// Adds the time since the last call, or since the start, to `stage`.
    #[inline(always)]
    pub fn lap(&mut self, stage: Stage) {
        if self.last.is_some() {
            self.count(stage);
        }
    }

    #[cold]
    fn count(&mut self, stage: Stage) {
        let now = Instant::now();
        if let Some(last) = self.last.replace(now) {
            self.spent[stage as usize] += now - last;
        }
    }
}

/// The processor time that all threads have spent in each stage, and the number of path segments and shadow rays.
#[derive(Debug, Default)]
pub struct StageTimes {
    nanoseconds: [AtomicU64; Stage::TABLE.len()],
    segments: AtomicU64,
}

impl StageTimes {
    /// The time in `stage`, summed over the threads.
    pub fn of(&self, stage: Stage) -> Duration {
        Duration::from_nanos(self.nanoseconds[stage as usize].load(Ordering::Relaxed))
    }

    /// The number of path segments, shadow rays not included.
    pub fn segments(&self) -> u64 {
        self.segments.load(Ordering::Relaxed)
    }

    pub(crate) fn add(&self, clock: &StageClock, segments: u64) {
        let wall: Duration = clock.spent.iter().sum();
        let cpu = clock
            .cpu
            .map_or(Duration::ZERO, |start| ThreadTime::now().as_duration() - start);
        let scale = cpu.as_secs_f64() / wall.as_secs_f64().max(f64::MIN_POSITIVE);
        for (sum, spent) in self.nanoseconds.iter().zip(clock.spent) {
            sum.fetch_add((spent.as_nanos() as f64 * scale) as u64, Ordering::Relaxed);
        }
        self.segments.fetch_add(segments, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_was_not_asked_counts_nothing() {
        let mut clock = StageClock::default();
        clock.start(false);
        clock.lap(Stage::Light);
        assert!(clock.spent.iter().all(Duration::is_zero));
    }

    #[test]
    fn every_lap_counts_to_its_stage_alone() {
        let mut clock = StageClock::default();
        clock.start(true);
        let cpu = ThreadTime::now();
        while cpu.elapsed() < Duration::from_millis(2) {}
        clock.lap(Stage::Light);
        clock.lap(Stage::Film);
        let times = StageTimes::default();
        times.add(&clock, 7);
        assert!(times.of(Stage::Light) >= Duration::from_millis(1) && times.of(Stage::Bsdf).is_zero());
        assert!(times.of(Stage::Film) < times.of(Stage::Light));
        assert_eq!(times.segments(), 7);
    }

    #[test]
    fn a_thread_that_waits_spends_no_processor_time() {
        let mut clock = StageClock::default();
        clock.start(true);
        std::thread::sleep(Duration::from_millis(50));
        clock.lap(Stage::Light);
        let times = StageTimes::default();
        times.add(&clock, 0);
        assert!(
            times.of(Stage::Light) < Duration::from_millis(25),
            "{:?}",
            times.of(Stage::Light)
        );
    }

    #[test]
    fn the_table_is_in_the_order_of_the_stages() {
        assert!(
            Stage::TABLE
                .iter()
                .enumerate()
                .all(|(i, (stage, _))| *stage as usize == i)
        );
    }
}
