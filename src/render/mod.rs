//! Rendering: waves of paths over the tiles of a film, on all threads.

use crate::{
    camera::{Camera, FrameCamera},
    film::{Film, PassSpec, passes},
    integrator::Integrator,
    scene::Scene,
    value::UnknownName,
};

pub mod adaptive;
mod batch_inputs;
mod camera_rays;
mod context;
mod control;
mod interrupts;
mod invalid_samples;
mod sample_block;
pub mod schedule;
mod settings;
mod tile_result;
mod tile_set;
mod tiles;
mod transparency;
mod wave;
mod wave_pool;
mod wave_stats;

pub use adaptive::AdaptiveSampling;
pub use control::{Cancel, Cancelled, Control, Counters, TileSink};
pub use interrupts::{Interrupts, PartialFrame, ShowRequest};
pub use invalid_samples::InvalidSamples;
pub use schedule::SampleBudget;
pub use settings::{Content, Settings};
pub use tile_result::TileResult;

use context::RenderContext;
use wave_pool::WavePool;

/// Why a frame was not rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A pass shows a light group that the scene does not have.
    #[error(transparent)]
    Pass(#[from] UnknownName),
}

/// Renders frames, and reuses the memory of its waves.
#[derive(Default)]
pub struct Renderer {
    waves: WavePool,
}

impl Renderer {
    pub fn new() -> Self {
        Self::default()
    }

    /// Renders one frame on the threads of the current rayon pool.
    ///
    /// The camera is in world space; it is moved to the scene's origin here.
    ///
    /// The bits of the film depend on the scene, the camera and the settings, never on threads, tiles, rounds or crops.
    ///
    /// # Errors
    /// The frame was cancelled, or a pass shows a light group that the scene does not have.
    pub fn render(
        &self,
        scene: &Scene,
        frame_camera: &FrameCamera,
        integrator: &dyn Integrator,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Film, RenderError> {
        let picture = picture_of(integrator);
        let layout = settings.film_layout(picture, scene.shading.light_groups.names())?;
        let layout = layout.with_mattes(|| scene.mattes());
        let frame_camera = &frame_camera.moved(-scene.origin);
        let context = RenderContext::new(scene, frame_camera, integrator, settings, &layout);
        Ok(tiles::render(&context, &layout, &self.waves, control)?)
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

/// Renders one frame of a still camera.
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
