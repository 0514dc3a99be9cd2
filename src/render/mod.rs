//! Rendering: waves of paths over the tiles of a film, on all threads.

use std::sync::Mutex;

use crate::{
    camera::{Camera, FrameCamera},
    film::{Film, FilmLayout, PassRequest, PassSpec, Window, passes},
    filter::Filter,
    integrator::Integrator,
    sampler::Sampler,
    scene::Scene,
    value::UnknownName,
};

mod camera_rays;
mod control;
mod invalid_samples;
mod sample_block;
pub mod schedule;
mod tiles;
mod transparency;
mod wave;

pub use control::{Cancel, Cancelled, Control, Counters, TileSink};
pub use invalid_samples::InvalidSamples;
pub use schedule::SampleBudget;
pub use tiles::TileResult;

use wave::{RenderContext, Wave};

/// What a frame is rendered with, beside its scene and its camera.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Columns and rows of the full picture.
    pub resolution: [u32; 2],
    /// The part of it to render.
    pub window: Window,
    pub samples: SampleBudget,
    pub seed: u32,
    /// The frame whose random numbers are drawn, see [`SeedMode`](crate::sampler::SeedMode).
    pub noise_frame: i32,
    pub sampler: Sampler,
    /// `None`: every sample goes through its pixel's centre.
    pub filter: Option<Filter>,
    pub content: Content,
    /// The passes of the film beside the beauty.
    pub passes: Vec<PassRequest>,
}

/// What is rendered of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Content {
    /// The picture of the integrator, and passes of what it is made of.
    #[default]
    Light,
    /// First hits alone, without light: rays go through the centres of pixels and of the lens when the shutter opens, and
    /// alpha is 0 where they meet nothing.
    FirstHits,
}

impl Settings {
    /// A whole picture of frame 1, with the filter that scenes have where they name none.
    pub fn new(resolution: [u32; 2], samples: u32) -> Self {
        Self {
            resolution,
            window: Window::full(resolution),
            samples: SampleBudget::fixed(samples),
            seed: 0,
            noise_frame: 1,
            sampler: Sampler::default_for(samples),
            filter: (samples > 1).then(Filter::default),
            content: Content::default(),
            passes: Vec::new(),
        }
    }
}

/// Why a frame was not rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A pass shows a light group that the scene does not have.
    #[error(transparent)]
    Pass(#[from] UnknownName),
}

/// Renders frames, and keeps the memory of its waves from one to the next.
#[derive(Default)]
pub struct Renderer {
    waves: Mutex<Vec<Wave>>,
}

impl Renderer {
    pub fn new() -> Self {
        Self::default()
    }

    /// Renders one frame on the threads of the current rayon pool.
    ///
    /// The film's bits depend on the scene, the camera and the settings; never on threads, tiles, rounds or crops.
    ///
    /// # Errors
    /// The frame was cancelled, or a pass shows a light group that the scene does not have.
    pub fn render(
        &self,
        scene: &Scene,
        shot: &FrameCamera,
        integrator: &dyn Integrator,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Film, RenderError> {
        let picture = picture_of(integrator);
        let layout = FilmLayout::new(picture, &settings.passes, scene.light_groups.names())?;
        let context = RenderContext::new(scene, shot, integrator, settings, &layout);
        Ok(tiles::render(&context, &layout, self, control)?)
    }

    fn take_wave(&self) -> Wave {
        self.lock_waves().pop().unwrap_or_default()
    }

    fn put_wave(&self, wave: Wave) {
        self.lock_waves().push(wave);
    }

    fn lock_waves(&self) -> std::sync::MutexGuard<'_, Vec<Wave>> {
        self.waves.lock().expect("no thread panics while it holds the waves")
    }
}

/// The pass that an integrator computes.
pub fn picture_of(integrator: &dyn Integrator) -> &'static PassSpec {
    if integrator.wants_cost() {
        passes::COST
    } else {
        passes::BEAUTY
    }
}

/// Renders one frame of a camera that stands still, with nobody watching.
///
/// # Errors
/// A pass shows a light group that the scene does not have.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    integrator: &dyn Integrator,
    settings: &Settings,
) -> Result<Film, RenderError> {
    Renderer::new().render(
        scene,
        &FrameCamera::from(*camera),
        integrator,
        settings,
        &Control::default(),
    )
}
