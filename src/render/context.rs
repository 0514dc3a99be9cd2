//! The data that all waves of a frame share.

use super::{Content, Settings, moments::Moment};
use crate::{
    camera::{Camera, FrameCamera},
    film::{AccumulatorLayout, FilmLayout, layout::Needs, passes::PassContext},
    integrator::{Integrator, PathState},
    math::{RayCone, Rgb, Vec2},
    sampler::{Dimension, PathSampler, SampleUse},
    scene::{MediumStack, Scene, SceneMotion, SurfaceInteraction},
    simd::Isa,
};

/// The data of a frame that stays while its scene moves.
pub(super) struct FrameInputs<'a> {
    /// The camera around the scene's origin.
    pub camera: FrameCamera,
    pub integrator: &'a dyn Integrator,
    pub settings: &'a Settings,
    pub layout: &'a FilmLayout,
    pub accumulators: AccumulatorLayout,
    /// The places of what moves, if a pass shows its motion.
    pub motion: Option<SceneMotion>,
}

/// The data that all waves of a frame share, of a moving scene those of a moment.
pub(super) struct RenderContext<'a> {
    pub scene: &'a Scene,
    pub frame_camera: &'a FrameCamera,
    /// The camera when the shutter opens.
    opening: Camera,
    /// The camera at the moment; without one, that when the shutter opens.
    pub camera: Camera,
    /// Whether each sample has a camera of its own.
    pub camera_moves: bool,
    pub integrator: &'a dyn Integrator,
    pub settings: &'a Settings,
    pub needs: Needs,
    pub accumulators: &'a AccumulatorLayout,
    pub frame: &'a FrameInputs<'a>,
    /// Whether paths may pass surfaces, by their opacity or because another medium fills the space.
    pub paths_pass: bool,
    /// Whether shadow rays may pass surfaces, or are attenuated by media.
    pub shadow_rays_pass: bool,
    /// Whether the scene has shadow catchers that the frame shows.
    pub has_catchers: bool,
    /// Whether hits are sorted by the kind of block that shades them.
    pub groups_hits: bool,
    /// The media around the camera.
    pub media: MediumStack,
    /// The SIMD level.
    pub simd: Isa,
    /// Whether every sample has a camera ray.
    pub fills_film: bool,
    /// The cone of each camera ray, if a texture needs it.
    pub cone: Option<RayCone>,
}

impl<'a> RenderContext<'a> {
    pub fn new(scene: &'a Scene, frame: &'a FrameInputs<'a>, moment: Option<Moment>) -> Self {
        let FrameInputs { camera, settings, .. } = frame;
        let (frame_camera, opening) = (camera, camera.camera(0.0));
        let camera = moment.map_or(opening, |moment| frame_camera.camera(moment.fraction() as f32));
        // A sample has its share of the centre pixel; other pixels subtend no larger angle.
        let has_catchers = scene.has_catchers() && settings.content == Content::Light && !frame.integrator.wants_cost();
        let passes_objects = scene.hides() || scene.culls_backs() || has_catchers;
        let cone = || camera.pixel_cone().shared(settings.planned_samples);
        Self {
            scene,
            frame_camera,
            opening,
            camera,
            camera_moves: moment.is_none() && frame_camera.moves(),
            integrator: frame.integrator,
            settings,
            needs: frame.layout.needs(),
            accumulators: &frame.accumulators,
            frame,
            paths_pass: !scene.is_opaque() || scene.shading.media.has_priorities() || passes_objects,
            shadow_rays_pass: !scene.is_opaque() || scene.shading.media.lets_shadow_rays_through() || passes_objects,
            has_catchers,
            groups_hits: frame.integrator.follows_one_direction() && scene.shading.bsdfs.mixes_batch_kinds(),
            media: media_of(scene, &camera),
            simd: scene.geometry.accel.simd(),
            fills_film: frame_camera.fills_film(),
            cone: scene.reads_footprints().then(cone),
        }
    }
}

impl RenderContext<'_> {
    /// The data that passes read beside first hits.
    pub fn passes(&self) -> PassContext<'_> {
        PassContext {
            camera: &self.opening,
            frame_camera: self.frame_camera,
            film: self.settings.resolution,
            scene: self.scene,
            motion: self.frame.motion.as_ref(),
        }
    }

    /// The camera when the shutter opens for a pixel, if it is not the same for all pixels.
    pub fn opening_for(&self, pixel: impl FnOnce() -> [i32; 2]) -> Option<Camera> {
        let rolls = self.frame_camera.moves() && !self.frame_camera.readout().is_global();
        let camera = || {
            let time = self.frame_camera.time_of_pixel(0.0, pixel(), self.settings.resolution);
            self.frame_camera.cameras().at(time)
        };
        rolls.then(camera)
    }

    /// Whether the camera sees the background.
    pub fn shows_background(&self) -> bool {
        self.scene.shading.background.visible && self.settings.content == Content::Light
    }

    /// Whether the camera sees a background that is not black: it is the plate behind shadow catchers.
    pub fn shows_plate(&self) -> bool {
        let background = &self.scene.shading.background;
        let is_black = match background.backdrop {
            Some(backdrop) => backdrop.is_black(),
            None => background.radiance.is_black(),
        };
        self.shows_background() && !is_black
    }

    /// The path of a sample before its first hit.
    pub fn path(&self, sample: u32) -> PathState {
        let mut path = PathState::start(sample);
        (path.cone, path.last.media) = (self.cone.unwrap_or_default(), self.media);
        path
    }

    /// An estimate of the albedo at the first surface, by the random numbers of the path's direction.
    pub fn sample_albedo(&self, surface: &SurfaceInteraction, path: &PathState, numbers: &PathSampler<'_>) -> Rgb {
        self.scene.sample_albedo(surface, path.last.media, || {
            let at = |sample_use| Dimension::at(path.depth, sample_use);
            let bsdf = at(SampleUse::Bsdf);
            (numbers.get_third(bsdf).f32(), numbers.get_sample_2d(bsdf))
        })
    }
}

/// The media around a camera: those around the centre of its lens.
fn media_of(scene: &Scene, camera: &Camera) -> MediumStack {
    let middle = Vec2::splat(0.5);
    let ray = camera.ray(middle, middle);
    ray.map_or(MediumStack::default(), |ray| scene.media_around(ray.o))
}
