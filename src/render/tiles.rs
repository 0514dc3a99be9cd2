//! The tiles of a frame, shared out to the threads, round by round.

use std::{ops::Range, sync::Mutex};

use rayon::prelude::*;

use super::{Cancelled, Control, TileResult, context::RenderContext, schedule, wave_pool::WavePool};
use crate::film::{Film, FilmLayout, TileAccumulator, Window};

/// Renders all rounds of a frame.
pub(super) fn render(
    context: &RenderContext<'_>,
    layout: &FilmLayout,
    waves: &WavePool,
    control: &Control<'_>,
) -> Result<Film, Cancelled> {
    let settings = context.settings;
    let film = Mutex::new(Film::new(settings.resolution, settings.window, layout));
    let threads = rayon::current_num_threads();
    let mut tiles: Vec<Tile> = schedule::tiles(settings.window, &settings.samples, threads)
        .map(|window| Tile {
            window,
            accumulator: None,
        })
        .collect();
    let mut done = 0;
    while let Some(samples) = schedule::next_round(&settings.samples, done) {
        done = samples.end;
        let is_last = schedule::next_round(&settings.samples, done).is_none();
        tiles.par_iter_mut().with_max_len(1).try_for_each(|tile| {
            if control.is_cancelled() {
                return Err(Cancelled);
            }
            tile.render(context, samples.clone(), waves, control)?;
            if is_last && let Some(finished) = tile.accumulator.take() {
                let mut film = film.lock().expect("no thread panics while it holds the film");
                finished.resolve_into(&context.accumulators, &mut film);
            }
            Ok(())
        })?;
    }
    Ok(film.into_inner().expect("no thread panics while it holds the film"))
}

struct Tile {
    window: Window,
    /// Its samples so far; `None` before the first round and after the last.
    accumulator: Option<TileAccumulator>,
}

impl Tile {
    fn render(
        &mut self,
        context: &RenderContext<'_>,
        samples: Range<u32>,
        waves: &WavePool,
        control: &Control<'_>,
    ) -> Result<(), Cancelled> {
        let layout = &context.accumulators;
        let accumulator = self
            .accumulator
            .get_or_insert_with(|| TileAccumulator::new(self.window, layout));
        let mut wave = waves.take();
        for block in schedule::blocks(self.window, samples.clone()) {
            // A wave that was cancelled holds paths of its block: it is dropped.
            let stats = wave.run(context, &block, accumulator, control)?;
            if let Some(counters) = control.counters {
                counters.add((block.samples.len() * block.tile.area()) as u64, &stats);
                counters.add_invalid(&stats.invalid);
            }
        }
        waves.put(wave);
        if let Some(sink) = control.sink {
            sink.tile(&TileResult {
                accumulator,
                layout,
                samples,
            });
        }
        Ok(())
    }
}
