//! The distribution of a frame's tiles to the threads, round by round.

use std::{
    ops::Range,
    sync::Mutex,
    time::{Duration, Instant},
};

use rayon::prelude::*;

use super::{
    Cancelled, Control, TileResult,
    context::RenderContext,
    interrupts::PartialFrame,
    schedule,
    tile_set::{Tile, TileSet},
    wave_pool::WavePool,
};
use crate::film::{Film, FilmLayout, TileAccumulator};

/// Why threads stopped before the end of a round.
enum Stop {
    Cancelled,
    /// The frame pauses.
    Due,
}

impl From<Cancelled> for Stop {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Renders all rounds of a frame.
pub(super) fn render(
    context: &RenderContext<'_>,
    layout: &FilmLayout,
    waves: &WavePool,
    control: &Control<'_>,
) -> Result<Film, Cancelled> {
    let (settings, interrupts) = (context.settings, control.interrupts);
    let start = Instant::now();
    let (mut tiles, before) = begin(context, control);
    let keeps_sums = interrupts.is_some_and(|i| i.keep_state());
    let mut film = Film::new(settings.resolution, settings.window, layout);
    let mut done = tiles.samples();
    while let Some(samples) = schedule::next_round(&settings.samples, done, before + start.elapsed()) {
        let finishes_tiles = samples.end == settings.samples.max && !keeps_sums;
        loop {
            let shared = Mutex::new(&mut film);
            let round = tiles.tiles.par_iter_mut().with_max_len(1).try_for_each(|tile| {
                if control.is_cancelled() {
                    return Err(Stop::Cancelled);
                }
                render_tile(tile, context, samples.clone(), waves, control)?;
                if finishes_tiles && let Some(finished) = tile.accumulator.take() {
                    let mut film = shared.lock().expect("no thread panics while it holds the film");
                    finished.resolve_into(&context.accumulators, &mut film);
                }
                Ok(())
            });
            let Err(stop) = round else { break };
            let is_cancelled = matches!(stop, Stop::Cancelled);
            if let Some(interrupts) = interrupts {
                interrupts.pause(&PartialFrame {
                    tiles: &tiles,
                    film: &film,
                    layout: &context.accumulators,
                    elapsed: before + start.elapsed(),
                    is_cancelled,
                });
            }
            if is_cancelled {
                return Err(Cancelled);
            }
        }
        done = samples.end;
        if tiles.are_converged() {
            done = settings.samples.max;
            break;
        }
    }
    tiles.resolve_into(&context.accumulators, &mut film);
    film.samples = done;
    Ok(film)
}

/// The tiles with the samples of an earlier, unfinished render, and its time.
fn begin(context: &RenderContext<'_>, control: &Control<'_>) -> (TileSet, Duration) {
    let settings = context.settings;
    let state = control.interrupts.and_then(|interrupts| interrupts.earlier_state());
    let earlier = state.and_then(|bytes| TileSet::from_state(settings, &context.accumulators, &bytes));
    earlier.unwrap_or_else(|| {
        let side = schedule::tile_side(settings.window, &settings.samples, rayon::current_num_threads());
        (TileSet::new(settings, side), Duration::ZERO)
    })
}

/// Renders those of the samples that a tile does not have yet and that its noise needs.
fn render_tile(
    tile: &mut Tile,
    context: &RenderContext<'_>,
    samples: Range<u32>,
    waves: &WavePool,
    control: &Control<'_>,
) -> Result<(), Stop> {
    if tile.reported == samples.end {
        return Ok(());
    }
    let (layout, budget) = (&context.accumulators, &context.settings.samples);
    let mut wave = waves.take();
    while tile.done < samples.end && !tile.is_converged {
        let stop = budget.next_stop(tile.done);
        for block in schedule::blocks(tile.window, tile.done..stop.min(samples.end)) {
            let accumulator = tile
                .accumulator
                .get_or_insert_with(|| TileAccumulator::new(tile.window, layout));
            // A cancelled wave still holds paths, so it is dropped.
            let stats = wave.run(context, &block, accumulator, control)?;
            tile.done = block.samples.end;
            if let Some(counters) = control.counters {
                counters.add((block.samples.len() * block.tile.area()) as u64, &stats);
                counters.add_invalid(&stats.invalid);
            }
            if tile.done == stop && stop < budget.max {
                tile.judge(budget.adaptive.as_ref());
                if let Some(counters) = control.counters.filter(|_| tile.is_converged) {
                    counters.add_saved(u64::from(budget.max - stop) * tile.window.area() as u64);
                }
            }
            if control.interrupts.is_some_and(|interrupts| interrupts.are_due()) {
                waves.put(wave);
                return Err(Stop::Due);
            }
        }
    }
    waves.put(wave);
    tile.reported = samples.end;
    if let Some((sink, accumulator)) = control.sink.zip(tile.accumulator.as_ref()) {
        sink.tile(&TileResult {
            accumulator,
            layout,
            window: context.settings.window,
            samples,
        });
    }
    Ok(())
}
