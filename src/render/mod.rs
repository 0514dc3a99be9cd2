//! Rendering: waves of paths over tiles of a film, on all threads.

use std::sync::{
    Mutex,
    atomic::{AtomicBool, AtomicU64, Ordering},
};

use crate::{
    camera::{Camera, Shot},
    film::{Film, Window},
    filter::Filter,
    integrator::Integrator,
    sampler::Sampler,
    scene::Scene,
};

mod camera_rays;
mod dropped;
mod part;
mod tiles;
mod transparency;
mod wave;

pub use dropped::Dropped;

/// What a frame is rendered with, beside its scene and its camera.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Columns and rows of the full picture.
    pub resolution: [u32; 2],
    /// The part of it to render.
    pub window: Window,
    /// Samples of each pixel.
    pub samples: u32,
    pub seed: u32,
    /// Which frame the random numbers are those of, see [`SeedMode`](crate::sampler::SeedMode).
    pub frame: i32,
    pub sampler: Sampler,
    /// `None`: every sample goes through its pixel's centre.
    pub filter: Option<Filter>,
    /// Whether the film has layers too, see [`Film::layers`](crate::film::Film::layers).
    pub layers: Layers,
}

/// What a film has beside the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layers {
    #[default]
    None,
    /// Its light by [`Component`](crate::integrator::Component) and by group of lights.
    Light,
}

impl Settings {
    /// A whole picture of frame 1, with the filter that scenes have where they name none.
    pub fn new(resolution: [u32; 2], samples: u32) -> Self {
        Self {
            resolution,
            window: Window::full(resolution),
            samples,
            seed: 0,
            frame: 1,
            sampler: Sampler::default_for(samples),
            filter: (samples > 1).then(Filter::default),
            layers: Layers::None,
        }
    }
}

/// What all threads of a frame are doing, for whoever watches, and the word to stop.
#[derive(Debug, Default)]
pub struct Watch {
    /// Pixels that are finished.
    pub pixels: AtomicU64,
    /// Rays traced for nearest hits and for shadows.
    pub rays: AtomicU64,
    /// Samples that came out as NaN or infinite, and were left out, since somebody took them from here.
    pub dropped: Mutex<Dropped>,
    /// Set by whoever watches: unfinished tiles are left.
    pub cancel: AtomicBool,
}

impl Watch {
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

/// The frame was given up because [`Watch::cancel`] was set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Renders one frame on the threads of the current rayon pool.
///
/// The film's bits depend on the scene, the camera and the settings; never on threads, tiles or what is cropped.
pub fn frame(
    scene: &Scene,
    camera: &Camera,
    integrator: &dyn Integrator,
    settings: &Settings,
    watch: &Watch,
) -> Result<Film, Cancelled> {
    shot(scene, &Shot::from(*camera), integrator, settings, watch)
}

/// The same for a camera that may move while its shutter is open.
pub fn shot(
    scene: &Scene,
    shot: &Shot,
    integrator: &dyn Integrator,
    settings: &Settings,
    watch: &Watch,
) -> Result<Film, Cancelled> {
    tiles::render(&wave::Job::new(scene, shot, integrator, settings), watch)
}
