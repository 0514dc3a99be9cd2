//! A film as tiles, shared out to the threads.

use std::sync::{Mutex, atomic::Ordering};

use rayon::prelude::*;

use super::{
    Cancelled, Watch,
    wave::{Job, PATHS, Wave},
};
use crate::film::{Film, PixelSum, Window};

/// Renders every tile of the window.
pub(super) fn render(job: &Job<'_>, watch: &Watch) -> Result<Film, Cancelled> {
    let settings = job.settings;
    let film = Mutex::new(Film::new(settings.resolution, settings.window));
    let idle = Mutex::new(Vec::<Wave>::new());
    let side = side(settings.samples, settings.window, rayon::current_num_threads());
    let tiles: Vec<Window> = settings.window.tiles(side).collect();
    tiles.par_iter().with_max_len(1).try_for_each(|tile| {
        if watch.is_cancelled() {
            return Err(Cancelled);
        }
        let mut wave = lock(&idle).pop().unwrap_or_default();
        let pixels = render_tile(job, *tile, &mut wave, watch);
        lock(&film).put(*tile, &pixels);
        lock(&idle).push(wave);
        watch.pixels.fetch_add(tile.area() as u64, Ordering::Relaxed);
        Ok(())
    })?;
    Ok(film.into_inner().expect("no thread panics while it holds the film"))
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().expect("no thread panics while it holds a lock")
}

/// The side of a tile: a wave's worth of paths with 16 or more samples of each pixel together, and small enough that
/// every thread has several.
fn side(samples: u32, window: Window, threads: usize) -> u32 {
    let together = samples.clamp(1, 16);
    let pixels = PATHS as u32 / together;
    let fair = (window.area() / (8 * threads)).max(64);
    let pixels = pixels.min(fair as u32).max(64);
    pixels.isqrt()
}

fn render_tile(job: &Job<'_>, tile: Window, wave: &mut Wave, watch: &Watch) -> Vec<[f32; 4]> {
    let samples = job.settings.samples;
    let mut sums = vec![PixelSum::default(); tile.area()];
    let together = (PATHS / tile.area()).max(1) as u32;
    let mut first = 0;
    while first < samples {
        let count = together.min(samples - first);
        let traced = wave.run(job, tile, first..first + count, &mut sums);
        watch.rays.fetch_add(traced.rays, Ordering::Relaxed);
        if traced.dropped.count > 0 {
            lock(&watch.dropped).add(&traced.dropped);
        }
        first += count;
    }
    sums.iter().map(PixelSum::resolve).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_holds_a_wave_of_sixteen_samples_and_every_thread_has_several() {
        let full = Window::full([1280, 720]);
        assert_eq!(side(16, full, 2), 32);
        assert_eq!(side(64, full, 2), 32);
        assert_eq!(side(1, full, 2), 128);
        assert!(side(1, Window::full([64, 64]), 2) <= 16);
    }
}
