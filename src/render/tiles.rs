//! The distribution of a frame's tiles to the threads, round by round and moment by moment.

use std::{
    ops::Range,
    sync::Mutex,
    time::{Duration, Instant},
};

use rayon::prelude::*;

use super::{
    Cancelled, Control, FrameScenes, RenderError, SampleBudget, SampleRanges, SceneTime, TileResult,
    context::{FrameInputs, RenderContext},
    interrupts::PartialFrame,
    moments::{Moment, Moments, Sweep},
    schedule,
    tile_set::{Tile, TileSet},
    wave_pool::WavePool,
};
use crate::film::Film;

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

/// The threads that share the tiles of frames whose samples are divided into ranges: their tiles are the same on all machines.
const THREADS_OF_RANGES: usize = 16;

/// Renders a frame, of a moving scene at these moments.
pub(super) fn render<S: FrameScenes>(
    frame: &FrameInputs<'_>,
    (scenes, moments): (&mut S, Option<Moments>),
    waves: &WavePool,
    control: &Control<'_>,
) -> Result<Film, S::Error> {
    let settings = frame.settings;
    let Some(ranges) = settings.ranges else {
        let mut progress = Progress::new(frame, moments, waves, (control, None));
        let done = progress.run((scenes, moments))?;
        return Ok(progress.finish(done));
    };
    let mut sums: Option<TileSet> = None;
    for index in ranges.indices() {
        let mut progress = Progress::new(frame, moments, waves, (control, Some((ranges, index))));
        progress.run((&mut *scenes, moments))?;
        progress.report_finished();
        match &mut sums {
            None => sums = Some(progress.tiles),
            Some(sums) => sums.append(&frame.accumulators, progress.tiles),
        }
    }
    let mut film = Film::new(settings.resolution, settings.window, frame.layout);
    film.samples = settings.pixel_samples();
    if let Some(sums) = sums {
        sums.resolve_into(&frame.accumulators, &mut film);
    }
    Ok(film)
}

/// A frame that is being rendered.
struct Progress<'a> {
    frame: &'a FrameInputs<'a>,
    waves: &'a WavePool,
    control: &'a Control<'a>,
    /// The budget of the frame, or of a range of its samples.
    budget: SampleBudget,
    /// The number of that range.
    range: Option<u32>,
    tiles: TileSet,
    film: Film,
    start: Instant,
    /// The time that an earlier, unfinished render took.
    before: Duration,
}

impl<'a> Progress<'a> {
    /// Begins a frame, or one of the ranges of its samples, with the samples of an earlier render.
    fn new(
        frame: &'a FrameInputs<'a>,
        moments: Option<Moments>,
        waves: &'a WavePool,
        (control, range): (&'a Control<'a>, Option<(SampleRanges, u32)>),
    ) -> Self {
        let settings = frame.settings;
        let all = 0..settings.samples.max;
        let samples = range.map_or(all, |(ranges, index)| ranges.range(index, settings.samples.max));
        let budget = SampleBudget {
            max: samples.end,
            ..settings.samples
        };
        let number = range.map(|(_, index)| index);
        let layout = (&frame.accumulators, moments.is_some());
        let state = control
            .interrupts
            .and_then(|interrupts| interrupts.earlier_state(number));
        let earlier = state.and_then(|bytes| {
            let found = TileSet::from_state((settings, &budget), layout, &bytes);
            if let (None, Some(interrupts)) = (&found, control.interrupts) {
                interrupts.earlier_state_is_left();
            }
            found
        });
        let (tiles, before) = earlier.unwrap_or_else(|| {
            let times = moments.map_or(1, Moments::of_pixel);
            let threads = range.map_or_else(rayon::current_num_threads, |_| THREADS_OF_RANGES);
            let side = schedule::tile_side(settings.window, &settings.samples, times, threads);
            (TileSet::new(settings, samples.start, side), Duration::ZERO)
        });
        Self {
            frame,
            waves,
            control,
            budget,
            range: number,
            tiles,
            film: Film::new(settings.resolution, settings.window, frame.layout),
            start: Instant::now(),
            before,
        }
    }

    /// Renders all rounds. Returns the number of samples of each pixel.
    fn run<S: FrameScenes>(&mut self, (scenes, moments): (&mut S, Option<Moments>)) -> Result<u32, S::Error> {
        let mut done = self.tiles.samples();
        while let Some(mut samples) = self.next_round(moments.is_some(), done) {
            if let Some(moments) = moments {
                samples = self.tiles.begin_sweep(schedule::sweep(&self.budget, samples));
                for moment in (0..moments.count()).map(|index| moments.get(index)) {
                    if self.tiles.lack(moment, &samples) {
                        let scene = scenes.at(moment.time())?;
                        let context = RenderContext::new(scene, self.frame, Some(moment));
                        let rendered = self.moment(&context, moment, &samples);
                        rendered.map_err(RenderError::from)?;
                    }
                }
                self.end_sweep(&samples).map_err(RenderError::from)?;
            } else {
                let context = RenderContext::new(scenes.at(SceneTime::OPENING)?, self.frame, None);
                self.round(&context, &samples).map_err(RenderError::from)?;
            }
            done = samples.end;
            if self.tiles.are_converged() {
                done = self.budget.max;
                break;
            }
        }
        Ok(done)
    }

    fn next_round(&self, moves: bool, done: u32) -> Option<Range<u32>> {
        let elapsed = self.before + self.start.elapsed();
        schedule::next_round(&self.budget, moves, done, elapsed).or(self.tiles.sweep.clone())
    }

    /// Gives all tiles these samples.
    fn round(&mut self, context: &RenderContext<'_>, samples: &Range<u32>) -> Result<(), Cancelled> {
        let (frame, waves, control) = (self.frame, self.waves, self.control);
        let finishes_tiles = self.finishes_tiles(samples);
        self.on_all(1, |tiles, film| {
            tiles.iter_mut().try_for_each(|tile| {
                render_tile(tile, context, samples.clone(), waves, control)?;
                if finishes_tiles {
                    resolve(tile, frame, film);
                }
                Ok(())
            })
        })
    }

    /// Gives all tiles those of these samples that belong to a moment.
    fn moment(&mut self, context: &RenderContext<'_>, moment: Moment, samples: &Range<u32>) -> Result<(), Cancelled> {
        let (waves, control) = (self.waves, self.control);
        let largest = self.tiles.tiles.iter().map(|tile| tile.window.area()).max();
        let together = moment.tiles_of_wave(largest.unwrap_or(1), samples.len());
        let share = self.tiles.tiles.len() / (4 * rayon::current_num_threads());
        self.on_all(together.min(share).max(1), |tiles, _| {
            render_moment(tiles, context, (moment, samples.clone()), waves, control)
        })
    }

    /// Ends the round of these samples, which all tiles have of all moments.
    fn end_sweep(&mut self, samples: &Range<u32>) -> Result<(), Cancelled> {
        let (frame, control) = (self.frame, self.control);
        let finishes_tiles = self.finishes_tiles(samples);
        self.on_all(1, |tiles, film| {
            for tile in tiles {
                if !tile.is_converged && tile.done < samples.end {
                    (tile.done, tile.moments) = (samples.end, 0);
                    judge(tile, frame, control);
                }
                report(tile, frame, samples, control);
                if finishes_tiles {
                    resolve(tile, frame, film);
                }
            }
            Ok(())
        })?;
        self.tiles.sweep = None;
        Ok(())
    }

    /// Whether tiles need their sums no longer after a round of these samples.
    fn finishes_tiles(&self, samples: &Range<u32>) -> bool {
        let keeps_sums = self.range.is_some() || self.control.interrupts.is_some_and(|i| i.keep_state());
        samples.end == self.budget.max && !keeps_sums
    }

    /// Does `work` for all tiles, so many together, on all threads. It is repeated for all of them after a pause.
    fn on_all(
        &mut self,
        together: usize,
        work: impl Fn(&mut [Tile], &Mutex<&mut Film>) -> Result<(), Stop> + Sync,
    ) -> Result<(), Cancelled> {
        let control = self.control;
        loop {
            let shared = Mutex::new(&mut self.film);
            let tiles = self.tiles.tiles.par_chunks_mut(together).with_max_len(1);
            let done = tiles.try_for_each(|tiles| {
                if control.is_cancelled() {
                    return Err(Stop::Cancelled);
                }
                work(tiles, &shared)
            });
            let Err(stop) = done else { return Ok(()) };
            let is_cancelled = matches!(stop, Stop::Cancelled);
            if let Some(interrupts) = control.interrupts {
                interrupts.pause(&self.partial(is_cancelled));
            }
            if is_cancelled {
                return Err(Cancelled);
            }
        }
    }

    /// The frame as it stands.
    fn partial(&self, is_cancelled: bool) -> PartialFrame<'_> {
        PartialFrame {
            tiles: &self.tiles,
            film: &self.film,
            layout: &self.frame.accumulators,
            budget: &self.budget,
            elapsed: self.before + self.start.elapsed(),
            is_cancelled,
        }
    }

    /// Tells that the tiles have all samples.
    fn report_finished(&self) {
        if let Some(interrupts) = self.control.interrupts.filter(|i| i.keep_state()) {
            // The time that it took is of no use to a job that goes on from here.
            let elapsed = Duration::ZERO;
            interrupts.finished(&PartialFrame {
                elapsed,
                ..self.partial(false)
            });
        }
    }

    /// The film of the finished frame, whose pixels have `samples`.
    fn finish(mut self, samples: u32) -> Film {
        self.report_finished();
        self.tiles.resolve_into(&self.frame.accumulators, &mut self.film);
        self.film.samples = samples;
        self.film
    }
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
    let (frame, budget) = (context.frame, &context.settings.samples);
    let mut wave = waves.take();
    while tile.done < samples.end && !tile.is_converged {
        let stop = budget.next_stop(tile.done);
        for block in schedule::blocks(tile.window, tile.done..stop.min(samples.end)) {
            // A cancelled wave still holds paths, so it is dropped.
            let stats = wave.run(context, &block, tile.sums(frame), control)?;
            tile.done = block.samples.end;
            if let Some(counters) = control.counters {
                counters.add((block.samples.len() * block.tile.area()) as u64, &stats);
            }
            judge(tile, frame, control);
            if is_due(control) {
                waves.put(wave);
                return Err(Stop::Due);
            }
        }
    }
    waves.put(wave);
    report(tile, frame, &samples, control);
    Ok(())
}

/// Renders those of the samples that belong to a moment and that the tiles do not have yet.
fn render_moment(
    tiles: &mut [Tile],
    context: &RenderContext<'_>,
    (moment, samples): (Moment, Range<u32>),
    waves: &WavePool,
    control: &Control<'_>,
) -> Result<(), Stop> {
    let mut open: Vec<&mut Tile> = tiles.iter_mut().filter(|tile| tile.lacks(moment, &samples)).collect();
    if open.is_empty() {
        return Ok(());
    }
    let mut sweep = Sweep {
        tiles: open
            .iter_mut()
            .map(|tile| (tile.window, tile.sums(context.frame)))
            .collect(),
        samples: [samples.start, samples.end],
        moment,
    };
    let mut wave = waves.take();
    // A cancelled wave still holds paths, so it is dropped.
    let (stats, count) = wave.run_moment(context, &mut sweep, control)?;
    waves.put(wave);
    for tile in open {
        tile.moments += 1;
    }
    if let Some(counters) = control.counters {
        counters.add(count, &stats);
    }
    if is_due(control) { Err(Stop::Due) } else { Ok(()) }
}

fn is_due(control: &Control<'_>) -> bool {
    control.interrupts.is_some_and(|interrupts| interrupts.are_due())
}

/// Decides at a stop whether a tile has enough samples.
fn judge(tile: &mut Tile, frame: &FrameInputs<'_>, control: &Control<'_>) {
    let budget = &frame.settings.samples;
    if !budget.is_stop(tile.done) {
        return;
    }
    tile.judge(budget.adaptive.as_ref());
    if let Some(counters) = control.counters.filter(|_| tile.is_converged) {
        counters.add_saved(u64::from(budget.max - tile.done) * tile.window.area() as u64);
    }
}

/// Reports a tile with the samples of a round.
fn report(tile: &mut Tile, frame: &FrameInputs<'_>, samples: &Range<u32>, control: &Control<'_>) {
    tile.reported = samples.end;
    if let Some((sink, accumulator)) = control.sink.zip(tile.accumulator.as_ref()) {
        sink.tile(&TileResult {
            accumulator,
            layout: &frame.accumulators,
            window: frame.settings.window,
            samples: samples.clone(),
        });
    }
}

/// Writes the pixels of a finished tile into the film, and frees its sums.
fn resolve(tile: &mut Tile, frame: &FrameInputs<'_>, film: &Mutex<&mut Film>) {
    if let Some(finished) = tile.accumulator.take() {
        let mut film = film.lock().expect("no thread panics while it holds the film");
        finished.resolve_into(&frame.accumulators, &mut film);
    }
}
