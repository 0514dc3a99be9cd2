//! The data that all waves of a frame share.

use super::Settings;
use crate::{
    camera::{Camera, FrameCamera},
    film::{FilmLayout, accumulator::AccumulatorLayout, layout::Needs},
    integrator::{Integrator, PathState},
    math::{RayCone, Rgb, Vec2},
    sampler::{Dimension, PathSampler, SampleUse},
    scene::{MediumStack, Scene, SurfaceInteraction},
    simd::Isa,
};

/// The data that all waves of a frame share.
pub(super) struct RenderContext<'a> {
    pub scene: &'a Scene,
    pub frame_camera: &'a FrameCamera,
    /// The camera when the shutter opens.
    pub camera: Camera,
    pub integrator: &'a dyn Integrator,
    pub settings: &'a Settings,
    pub needs: Needs,
    pub accumulators: AccumulatorLayout,
    /// Whether paths may pass surfaces, by their opacity or because another medium fills the space.
    pub paths_pass: bool,
    /// Whether shadow rays may pass surfaces, or are attenuated by media.
    pub shadow_rays_pass: bool,
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
    pub fn new(
        scene: &'a Scene,
        frame_camera: &'a FrameCamera,
        integrator: &'a dyn Integrator,
        settings: &'a Settings,
        layout: &FilmLayout,
    ) -> Self {
        // A sample has its share of the centre pixel; other pixels subtend no larger angle.
        let camera = frame_camera.camera(0.0);
        let cone = || camera.pixel_cone().shared(settings.samples.max);
        Self {
            scene,
            frame_camera,
            camera,
            integrator,
            settings,
            needs: layout.needs(),
            accumulators: settings.accumulator_layout(layout),
            paths_pass: !scene.is_opaque() || scene.shading.media.has_priorities(),
            shadow_rays_pass: !scene.is_opaque() || scene.shading.media.lets_shadow_rays_through(),
            media: media_of(scene, &camera),
            simd: scene.geometry.accel.simd(),
            fills_film: frame_camera.fills_film(),
            cone: scene.reads_footprints().then(cone),
        }
    }
}

impl RenderContext<'_> {
    /// An estimate of the albedo at the first surface, by the random numbers of the path's direction.
    pub fn sample_albedo(&self, surface: &SurfaceInteraction, path: &PathState, numbers: &PathSampler<'_>) -> Rgb {
        self.scene.sample_albedo(surface, path.last.media, || {
            let at = |sample_use| Dimension::at(path.depth, sample_use);
            let selection = numbers.get_2d(at(SampleUse::Selection));
            (selection.y, numbers.get_sample_2d(at(SampleUse::Bsdf)))
        })
    }
}

/// The media around a camera: those around the centre of its lens.
fn media_of(scene: &Scene, camera: &Camera) -> MediumStack {
    let middle = Vec2::splat(0.5);
    let ray = camera.ray(middle, middle);
    ray.map_or(MediumStack::default(), |ray| scene.media_around(ray.o))
}
