//! The tiles of a frame with their samples so far.

use std::{ops::Range, time::Duration};

use super::{AdaptiveSampling, SampleBudget, Settings, context::FrameInputs, moments::Moment, schedule};
use crate::film::{AccumulatorLayout, Film, TileAccumulator, Window};

/// A tile of a frame.
pub(super) struct Tile {
    pub window: Window,
    /// The number of samples of each pixel so far.
    pub done: u32,
    /// The number of moments of a shutter at which those of the next samples have been taken that belong to them.
    pub moments: u32,
    /// Whether its noise is low enough, so that it gets no more samples.
    pub is_converged: bool,
    /// The end of the last round that was reported to a sink.
    pub reported: u32,
    /// The sums of its samples; `None` before the first sample, and once they are in the film.
    pub accumulator: Option<TileAccumulator>,
}

impl Tile {
    /// Whether it is to get those of these samples that belong to a moment.
    pub fn lacks(&self, moment: Moment, samples: &Range<u32>) -> bool {
        !self.is_converged && self.done < samples.end && self.moments <= moment.index()
    }

    /// The sums of its samples.
    pub fn sums(&mut self, frame: &FrameInputs<'_>) -> &mut TileAccumulator {
        let Self {
            window, accumulator, ..
        } = self;
        accumulator.get_or_insert_with(|| TileAccumulator::new(*window, &frame.accumulators))
    }

    /// Decides whether the samples so far are enough by this rule, without which they never are.
    pub fn judge(&mut self, rule: Option<&AdaptiveSampling>) {
        let Some(accumulator) = &mut self.accumulator else {
            return;
        };
        self.is_converged = rule.is_some_and(|rule| accumulator.error(rule.gain) < f64::from(rule.threshold));
        if !self.is_converged {
            accumulator.start_second_half();
        }
    }
}

/// The tiles of a frame.
pub(super) struct TileSet {
    side: u32,
    /// The samples that are being taken moment by moment; `None` before the first moment and after the last.
    pub sweep: Option<Range<u32>>,
    pub tiles: Vec<Tile>,
}

impl TileSet {
    /// The tiles of a frame before its sample number `first`; `side` is their side unless sampling is adaptive.
    pub fn new(settings: &Settings, first: u32, side: u32) -> Self {
        let tile = |window| Tile {
            window,
            done: first,
            moments: 0,
            is_converged: false,
            reported: 0,
            accumulator: None,
        };
        let tiles = schedule::tiles(settings.window, settings.resolution, &settings.samples, side);
        Self {
            side,
            sweep: None,
            tiles: tiles.into_iter().map(tile).collect(),
        }
    }

    /// Begins to take these samples moment by moment, or continues with those of an earlier, unfinished render, and returns them.
    pub fn begin_sweep(&mut self, samples: Range<u32>) -> Range<u32> {
        self.sweep.get_or_insert(samples).clone()
    }

    /// Whether any tile is to get those of these samples that belong to a moment.
    pub fn lack(&self, moment: Moment, samples: &Range<u32>) -> bool {
        self.tiles.iter().any(|tile| tile.lacks(moment, samples))
    }

    /// Whether all tiles have converged.
    pub fn are_converged(&self) -> bool {
        self.tiles.iter().all(|tile| tile.is_converged)
    }

    /// The least number of samples of all tiles that have not converged.
    pub fn samples(&self) -> u32 {
        let open = self.tiles.iter().filter(|tile| !tile.is_converged);
        let least = open.map(|tile| tile.done).min();
        least.or(self.tiles.iter().map(|tile| tile.done).max()).unwrap_or(0)
    }

    /// Writes the current pixels into a film, except those without samples and those that it already has.
    pub fn resolve_into(&self, layout: &AccumulatorLayout, film: &mut Film) {
        for tile in &self.tiles {
            if let Some(accumulator) = &tile.accumulator {
                accumulator.resolve_into(layout, film);
            }
        }
    }

    /// The state of a frame with this budget as bytes; `elapsed` is the rendering time so far. The
    /// sums of all samples must be present.
    pub fn state(&self, budget: &SampleBudget, elapsed: Duration) -> Vec<u8> {
        let mut out = Vec::new();
        out.extend([self.side, budget.max].map(u32::to_le_bytes).as_flattened());
        out.extend(elapsed.as_secs_f64().to_le_bytes());
        let Range { start, end } = self.sweep.clone().unwrap_or_default();
        out.extend([start, end].map(u32::to_le_bytes).as_flattened());
        for tile in &self.tiles {
            out.extend([tile.done, tile.moments].map(u32::to_le_bytes).as_flattened());
            out.push(u8::from(tile.is_converged));
            out.push(u8::from(tile.accumulator.is_some()));
            if let Some(accumulator) = &tile.accumulator {
                accumulator.write_state(&mut out);
            }
        }
        out
    }

    /// The tiles of a frame with this state, and their rendering time; `None` if the bytes are not such a state, or if it has
    /// another number of samples and moves or cannot be [extended](Self::extend).
    pub fn from_state(
        (settings, budget): (&Settings, &SampleBudget),
        (layout, moves): (&AccumulatorLayout, bool),
        mut bytes: &[u8],
    ) -> Option<(Self, Duration)> {
        let [side, max] = [take(&mut bytes)?, take(&mut bytes)?].map(|bytes| u32::from_le_bytes(*bytes));
        let elapsed = Duration::try_from_secs_f64(f64::from_le_bytes(*take(&mut bytes)?)).ok()?;
        if side == 0 {
            return None;
        }
        let mut set = Self::new(settings, 0, side);
        let [start, end] = [take(&mut bytes)?, take(&mut bytes)?].map(|bytes| u32::from_le_bytes(*bytes));
        set.sweep = Some(start..end).filter(|sweep| !sweep.is_empty());
        for tile in &mut set.tiles {
            [tile.done, tile.moments] = [take(&mut bytes)?, take(&mut bytes)?].map(|bytes| u32::from_le_bytes(*bytes));
            let [is_converged, has_sums] = *take(&mut bytes)?;
            tile.is_converged = is_converged != 0;
            if has_sums != 0 {
                let mut accumulator = TileAccumulator::new(tile.window, layout);
                accumulator.read_state(&mut bytes)?;
                tile.accumulator = Some(accumulator);
            }
        }
        if !bytes.is_empty() {
            return None;
        }
        if max != budget.max {
            if moves {
                // The samples of a larger budget are in another order.
                return None;
            }
            let earlier = SampleBudget { max, ..*budget };
            set.extend(&earlier, budget, layout.is_by_halves())?;
        }
        Some((set, elapsed))
    }

    /// Adds the sums of a later range of samples of the same tiles.
    pub fn append(&mut self, layout: &AccumulatorLayout, later: Self) {
        for (own, later) in self.tiles.iter_mut().zip(later.tiles) {
            match (&mut own.accumulator, later.accumulator) {
                (Some(own), Some(later)) => own.append(layout, &later),
                (own @ None, later) => *own = later,
                (Some(_), None) => {}
            }
        }
    }

    /// Makes tiles of a smaller budget those of a larger one after the same samples. `None` if these are not the samples that it
    /// begins with, in their order, or if they are divided into other halves.
    fn extend(&mut self, earlier: &SampleBudget, budget: &SampleBudget, is_by_halves: bool) -> Option<()> {
        let is_swept = self.sweep.is_some() || self.tiles.iter().any(|tile| tile.moments > 0);
        if is_swept || earlier.max > budget.max {
            return None;
        }
        for tile in self.tiles.iter_mut().filter(|tile| !tile.is_converged) {
            let half = budget.first_half(tile.done);
            if budget.is_stop(tile.done) && !earlier.is_stop(tile.done) {
                tile.judge(budget.adaptive.as_ref());
            } else if is_by_halves && half != earlier.first_half(tile.done) {
                let accumulator = tile.accumulator.as_mut().filter(|_| half == tile.done);
                accumulator?.start_second_half();
            }
        }
        Some(())
    }
}

fn take<'a, const N: usize>(bytes: &mut &'a [u8]) -> Option<&'a [u8; N]> {
    let (taken, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(taken)
}
