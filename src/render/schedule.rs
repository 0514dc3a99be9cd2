//! The schedule of a frame: which samples of which pixels are rendered next. Nothing here renders.
//!
//! A frame is rendered in rounds. A round gives every tile a range of samples. The tiles' accumulators are kept between rounds,
//! so that an early picture with few samples gets better. The bits of the finished frame do not depend on its division into
//! rounds, tiles and blocks.

use std::{ops::Range, time::Duration};

use super::{AdaptiveSampling, adaptive};
use crate::film::Window;

/// The number of paths that start together. More bring no gain, fewer make batches of rays too small.
pub(super) const WAVE_SIZE: usize = 4 * 1024;

/// The number of samples of each pixel, and the rounds in which they are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleBudget {
    /// The samples of the first round, at least 1.
    pub min: u32,
    /// The samples of the finished frame. Each round after the first doubles the number of samples up to this one.
    pub max: u32,
    /// The rule of adaptive sampling; `None` if all pixels get the same number of samples.
    pub adaptive: Option<AdaptiveSampling>,
    /// The time limit of a frame, which gets as many samples as fit and at least one.
    pub time: Option<Duration>,
    /// Whether each round doubles the samples up to `max`, so that a frame that a time limit ends has two halves of its samples.
    pub doubles: bool,
}

impl SampleBudget {
    /// All samples in one round.
    pub const fn fixed(samples: u32) -> Self {
        Self {
            min: samples,
            max: samples,
            adaptive: None,
            time: None,
            doubles: false,
        }
    }

    /// One sample in the first round, and twice as many after each further round.
    pub const fn progressive(samples: u32) -> Self {
        Self {
            min: 1,
            max: samples,
            adaptive: None,
            time: None,
            doubles: false,
        }
    }

    /// The number of samples at which a tile with `done` samples stops next: for a check, because they are the first half of the
    /// next stop's, or because it has all of them.
    pub fn next_stop(&self, done: u32) -> u32 {
        match self.adaptive {
            Some(rule) => rule.next_check(done).min(self.max),
            // Two samples at least have halves.
            None if self.doubles => {
                let halved = std::iter::successors(Some(self.max), |stop| Some(stop / 2));
                halved.take_while(|stop| *stop > done.max(1)).last().unwrap_or(self.max)
            }
            None => self.max,
        }
    }

    /// Whether a tile with `done` samples stops, and is not finished.
    pub fn is_stop(&self, done: u32) -> bool {
        done < self.max && done > 0 && self.next_stop(done - 1) == done
    }

    /// The number of samples in the first half of those of a tile with `done` samples: all of them at a stop, and up to half of the
    /// first one.
    pub fn first_half(&self, done: u32) -> u32 {
        let first = self.next_stop(0);
        let stops = std::iter::successors(Some(first), |stop| Some(self.next_stop(*stop)));
        let last = stops.take_while(|stop| *stop <= done && *stop < self.max).last();
        last.unwrap_or_else(|| done.min(first / 2))
    }

    /// The same budget with a time limit.
    pub const fn within(self, time: Duration) -> Self {
        Self {
            time: Some(time),
            ..self
        }
    }
}

/// The samples of the next round after `done` samples and the time `elapsed`; `None` if the frame is finished or has no time
/// for another sample.
///
/// With a time limit, rounds are as short as waves allow, and none is started that would exceed the remaining time by the pace
/// so far. A budget that doubles has a round for each of its stops. Rounds that `are_fixed` depend on the time only by their number,
/// for frames whose bits depend on the rounds.
pub fn next_round(budget: &SampleBudget, are_fixed: bool, done: u32, elapsed: Duration) -> Option<Range<u32>> {
    /// The samples of a pixel that a wave of a tile holds.
    const WAVE_SAMPLES: u32 = 16;
    let doubled = budget.next_stop(done) - done;
    let first = match budget.time {
        Some(_) if budget.doubles => doubled,
        Some(_) => 1,
        None => budget.min.max(1),
    };
    let step = match (done, budget.time) {
        (0, _) => first,
        (_, None) => done,
        (_, Some(time)) => {
            let pace = elapsed.as_secs_f64() / f64::from(done);
            // The cast saturates.
            let fitting = (time.saturating_sub(elapsed).as_secs_f64() / pace) as u32;
            let wanted = match budget.doubles {
                true => doubled,
                false => done.min(WAVE_SAMPLES).min(budget.max - done),
            };
            match budget.doubles || are_fixed {
                true => Some(wanted).filter(|step| *step <= fitting).unwrap_or(0),
                false => fitting.min(wanted),
            }
        }
    };
    let end = done.saturating_add(step).min(budget.max);
    (done < end).then_some(done..end)
}

/// A range of samples of the pixels of a rectangle, which are traced together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockSpec {
    pub tile: Window,
    pub samples: Range<u32>,
}

/// The samples of a round that are taken together, moment by moment: those up to the next stop, and no more than waves hold.
pub fn sweep(budget: &SampleBudget, round: Range<u32>) -> Range<u32> {
    const MOST: u32 = 4096;
    let stop = budget.next_stop(round.start).min(round.start.saturating_add(MOST));
    round.start..stop.min(round.end)
}

/// Divides these samples of the pixels of `tile` into blocks, in order. Each is as large as a wave, or has one sample of each
/// pixel.
pub fn blocks(tile: Window, samples: Range<u32>) -> impl Iterator<Item = BlockSpec> {
    let together = (WAVE_SIZE / tile.area().max(1)).max(1);
    let end = samples.end;
    samples.step_by(together).map(move |first| BlockSpec {
        tile,
        samples: first..end.min(first.saturating_add(together as u32)),
    })
}

/// The tiles of a window of a picture: squares of `side` pixels, or the blocks of adaptive sampling, which may extend beyond it.
pub fn tiles(window: Window, resolution: [u32; 2], budget: &SampleBudget, side: u32) -> Vec<Window> {
    match budget.adaptive {
        Some(_) => adaptive::blocks(window, resolution),
        None => window.tiles(side).collect(),
    }
}

/// The side of the tiles of a window. A tile holds a wave with at least 16 samples per pixel, and each of `threads` threads
/// gets several tiles. Where the samples are taken at `moments` times, it holds a wave of each.
pub fn tile_side(window: Window, budget: &SampleBudget, moments: u32, threads: usize) -> u32 {
    const MIN_PIXELS: u32 = 64;
    let together = budget.max.clamp(1, 16 * moments);
    let pixels = WAVE_SIZE as u32 * moments / together;
    let share = (window.area() / (8 * threads.max(1))).max(MIN_PIXELS as usize);
    pixels.min(share as u32).max(MIN_PIXELS).isqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first sample of each round, and the end of the last.
    fn rounds(budget: SampleBudget) -> Vec<u32> {
        let next = |done| next_round(&budget, false, done, Duration::ZERO);
        let rounds = std::iter::successors(next(0), |round| next(round.end));
        std::iter::once(0).chain(rounds.map(|round| round.end)).collect()
    }

    #[test]
    fn rounds_double_until_the_budget_is_spent_and_cover_every_sample_once() {
        assert_eq!(rounds(SampleBudget::fixed(48)), [0, 48]);
        assert_eq!(rounds(SampleBudget::progressive(6)), [0, 1, 2, 4, 6]);
        assert_eq!(
            rounds(SampleBudget {
                min: 4,
                ..SampleBudget::fixed(9)
            }),
            [0, 4, 8, 9]
        );
        assert_eq!(
            rounds(SampleBudget {
                min: 9,
                ..SampleBudget::fixed(4)
            }),
            [0, 4]
        );
        assert_eq!(rounds(SampleBudget::fixed(u32::MAX)), [0, u32::MAX]);
    }

    #[test]
    fn a_limit_of_time_is_kept_by_the_pace_so_far_and_leaves_one_sample_at_least() {
        let seconds = Duration::from_secs;
        let round = |samples: u32, are_fixed: bool| {
            move |limit, done, elapsed| {
                let budget = SampleBudget::fixed(samples).within(seconds(limit));
                next_round(&budget, are_fixed, done, seconds(elapsed))
            }
        };
        let next = round(64, false);
        assert_eq!(next(0, 0, 0), Some(0..1));
        assert_eq!(next(0, 1, 5), None);
        // Two samples in 2 s leave time for 8 more, but rounds double.
        assert_eq!(next(10, 2, 2), Some(2..4));
        assert_eq!(next(10, 8, 8), Some(8..10));
        assert_eq!(next(10, 10, 10), None);
        assert_eq!(next(100, 40, 4), Some(40..56));
        assert_eq!(next(100, 56, 4), Some(56..64));
        assert_eq!(next(100, 64, 4), None);
        let fixed = round(60, true);
        assert_eq!((fixed(10, 2, 2), fixed(10, 8, 8)), (Some(2..4), None));
        assert_eq!((fixed(100, 40, 4), fixed(100, 56, 4)), (Some(40..56), Some(56..60)));
    }

    #[test]
    fn a_budget_that_doubles_ends_at_half_of_the_samples_where_the_rest_does_not_fit() {
        let seconds = Duration::from_secs;
        let budget = SampleBudget {
            doubles: true,
            ..SampleBudget::fixed(50).within(seconds(10))
        };
        let stops = std::iter::successors(Some(budget.next_stop(0)), |stop| Some(budget.next_stop(*stop)));
        assert_eq!(stops.take(6).collect::<Vec<_>>(), [3, 6, 12, 25, 50, 50]);
        let next = |done, elapsed| next_round(&budget, false, done, seconds(elapsed));
        assert_eq!((next(0, 20), next(3, 5), next(3, 6)), (Some(0..3), Some(3..6), None));
        assert_eq!((next(25, 5), next(25, 6), next(50, 6)), (Some(25..50), None, None));
        // One sample has no halves, and two have.
        let of = |max| SampleBudget { max, ..budget }.next_stop(0);
        assert_eq!([1, 2, 3, 4].map(of), [1, 2, 3, 2]);
    }

    #[test]
    fn blocks_cover_the_samples_in_order_and_hold_a_wave_at_most() {
        for (side, samples) in [(16, 0..40), (64, 3..5), (8, 0..1)] {
            let tile = Window::full([side, side]);
            let mut next = samples.start;
            for block in blocks(tile, samples.clone()) {
                assert_eq!((block.tile, block.samples.start), (tile, next));
                assert!(block.samples.len() * tile.area() <= WAVE_SIZE || block.samples.len() == 1);
                next = block.samples.end;
            }
            assert_eq!(next, samples.end);
        }
    }

    #[test]
    fn a_tile_holds_a_wave_of_sixteen_samples_and_every_thread_has_several() {
        let full = Window::full([1280, 720]);
        let side = |samples, window| tile_side(window, &SampleBudget::fixed(samples), 1, 2);
        let wave = (WAVE_SIZE as u32 / 16).isqrt();
        assert_eq!((side(16, full), side(64, full)), (wave, wave));
        assert_eq!(side(1, full), (WAVE_SIZE as u32).isqrt());
        assert!(wave >= 16);
        assert!(side(1, Window::full([64, 64])) <= 16);
    }
}
