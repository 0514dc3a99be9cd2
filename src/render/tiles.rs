//! A film as tiles, shared out to the threads.

use std::sync::{Mutex, atomic::Ordering};

use rayon::prelude::*;

use super::{
    Cancelled, Layers, Watch,
    wave::{Job, PATHS, Sums, Wave},
};
use crate::{
    film::{Film, PixelSum, Window},
    integrator::Component,
};

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
        let sums = render_tile(job, *tile, &mut wave, watch);
        put(&film, *tile, &sums);
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

fn render_tile(job: &Job<'_>, tile: Window, wave: &mut Wave, watch: &Watch) -> Sums {
    let samples = job.settings.samples;
    let layers = match job.settings.layers {
        Layers::None => 0,
        Layers::Light => Component::ALL.len() + job.scene.light_groups.names().len(),
    };
    let mut sums = Sums {
        pixels: vec![PixelSum::default(); tile.area()],
        layers: vec![PixelSum::default(); tile.area() * layers],
    };
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
    sums
}

/// Resolves what `tile` has come to into the film.
fn put(film: &Mutex<Film>, tile: Window, sums: &Sums) {
    let pixels: Vec<_> = sums.pixels.iter().map(PixelSum::resolve).collect();
    lock(film).put(tile, &pixels);
    let layers = sums.layers.len() / sums.pixels.len().max(1);
    for layer in 0..layers {
        let of_layer = sums.layers.iter().skip(layer).step_by(layers);
        let pixels: Vec<_> = of_layer
            .map(|sum| sum.resolve())
            .map(|[r, g, b, _]| [r, g, b])
            .collect();
        lock(film).put_layer(layer, tile, &pixels);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_holds_a_wave_of_sixteen_samples_and_every_thread_has_several() {
        let full = Window::full([1280, 720]);
        let wave = (PATHS as u32 / 16).isqrt();
        assert_eq!(side(16, full, 2), wave);
        assert_eq!(side(64, full, 2), wave);
        assert_eq!(side(1, full, 2), (PATHS as u32).isqrt());
        assert!(wave >= 16);
        assert!(side(1, Window::full([64, 64]), 2) <= 16);
    }
}
