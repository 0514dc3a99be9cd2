//! Rendering: waves of paths over the tiles of a film, on all threads.

use crate::{
    camera::{Camera, FrameCamera},
    film::{Film, PassSpec, passes},
    integrator::Integrator,
    scene::Scene,
};

pub mod adaptive;
mod batch_inputs;
mod camera_rays;
mod context;
mod control;
mod error;
mod frame_scenes;
mod interrupts;
mod invalid_samples;
mod moments;
mod sample_block;
mod sample_ranges;
mod scene_time;
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
pub use error::RenderError;
pub use frame_scenes::{FrameScenes, StillScene};
pub use interrupts::{Interrupts, PartialFrame, ShowRequest};
pub use invalid_samples::InvalidSamples;
pub use moments::moment_times;
pub use sample_ranges::SampleRanges;
pub use scene_time::SceneTime;
pub use schedule::SampleBudget;
pub use settings::{Content, Settings};
pub use tile_result::TileResult;

use context::FrameInputs;
use moments::Moments;
use wave_pool::WavePool;

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
        self.render_moving(&mut StillScene(scene), frame_camera, integrator, settings, control)
    }

    /// Renders one frame of a scene that may move while the shutter is open, as [`Renderer::render`] does.
    ///
    /// The scene is sought at each moment of the shutter, of which there are 64 at least. With [`SampleBudget::progressive`], and
    /// with a time limit, the bits of the film also depend on the rounds: the samples of a round are added in the order of their
    /// moments.
    ///
    /// # Errors
    /// As those of [`Renderer::render`], and those of the scene.
    pub fn render_moving<S: FrameScenes>(
        &self,
        scenes: &mut S,
        frame_camera: &FrameCamera,
        integrator: &dyn Integrator,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Film, S::Error> {
        let scene = scenes.at(SceneTime::OPENING)?;
        let layout = settings.film_layout(picture_of(integrator), scene.shading.light_groups.names());
        let layout = layout.map_err(RenderError::from)?.with_mattes(|| scene.mattes());
        let mut accumulators = settings.accumulator_layout(&layout);
        if scene.has_catchers() {
            accumulators = accumulators.with_catchers();
        }
        let camera = frame_camera.moved(-scene.origin);
        let rolls = !camera.readout().is_global();
        let can_blur = rolls || camera.exposure() > 0.0 && settings.content == Content::Light;
        let moves = can_blur && !scenes.is_still(moment_times(settings, &camera));
        let follows_motion = layout.planes().iter().any(|plane| plane.pass.follows_motion());
        let moments = moves.then(|| Moments::new(settings, &camera));
        let frame = FrameInputs {
            motion: match follows_motion {
                true => frame_scenes::motion(scenes, camera.neighbours(), moves)?,
                false => None,
            },
            accumulators,
            camera,
            integrator,
            settings,
            layout: &layout,
        };
        tiles::render(&frame, (scenes, moments), &self.waves, control)
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
