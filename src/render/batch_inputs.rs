//! The inputs of a batch of vertices.

use super::context::RenderContext;
use crate::{
    geometry::Hit,
    integrator::{PathState, VertexBatch},
    light::environment::EnvironmentLight,
    math::Ray,
    sampler::{Dimension, SampleBatch, SampleKeys, SampleUse},
    scene::{LightNumbers, LightSamples, Scene, Surfaces},
};

/// The inputs of a batch of vertices, prepared before they are shaded.
#[derive(Default)]
pub(super) struct BatchInputs {
    pub surfaces: Surfaces,
    pub keys: SampleKeys,
    pub samples: SampleBatch,
    /// The light of the background for misses.
    pub misses: Vec<EnvironmentLight>,
    /// The light samples for surfaces.
    pub lights: LightSamples,
}

/// Traced rays, with their paths and hits.
#[derive(Clone, Copy)]
pub(super) struct ArrivedRays<'a> {
    pub rays: &'a [Ray],
    pub paths: &'a [PathState],
    pub hits: &'a [Option<Hit>],
    /// The number of samples of the wave.
    pub samples: u32,
    pub round: u32,
}

impl BatchInputs {
    /// Replaces the mixtures among the materials of the surfaces by one of their materials each, chosen by this dimension.
    pub fn choose_materials(&mut self, context: &RenderContext<'_>, dimension: Dimension) {
        let shading = &context.scene.shading;
        for (i, surface) in self.surfaces.interactions.iter_mut().enumerate() {
            if shading.material(surface.material).mixture().is_some() {
                let number = context.settings.sampler.get_2d(&self.keys.get(i), dimension).x;
                surface.material = shading.unmixed(surface.material, &surface.texture, number);
            }
        }
    }

    /// Gives the surfaces whose black backs are seen the material of these.
    pub fn blacken_backs(&mut self, scene: &Scene) {
        if scene.has_black_backs() {
            for surface in &mut self.surfaces.interactions {
                scene.blacken_back(surface);
            }
        }
    }

    /// Samples the lights for those surfaces whose random numbers are drawn.
    pub fn sample_lights(&mut self, context: &RenderContext<'_>) {
        let (scene, on) = (context.scene, context.simd);
        self.lights.clear();
        if let Some(numbers) = self.samples.of(SampleUse::Background) {
            scene.sample_background(on, numbers, &mut self.lights);
        }
        if let Some(points) = self.samples.of(SampleUse::Light) {
            let choices = self.samples.thirds_of(SampleUse::Light);
            let numbers = LightNumbers {
                choices: choices.filter(|_| scene.lights.has_choice()),
                points,
            };
            scene.sample_lights(on, &self.surfaces.interactions, numbers, &mut self.lights);
        }
    }

    /// The batch of the paths with these indices, for which these inputs were prepared.
    pub fn batch<'a>(
        &'a self,
        context: &'a RenderContext<'_>,
        arrived: ArrivedRays<'a>,
        indices: &'a [u32],
    ) -> VertexBatch<'a> {
        let ArrivedRays {
            rays,
            paths,
            hits,
            samples,
            round,
        } = arrived;
        VertexBatch {
            scene: context.scene,
            camera: &context.camera,
            sampler: &context.settings.sampler,
            rays,
            paths,
            hits,
            indices,
            surfaces: &self.surfaces.interactions,
            blocks: self.surfaces.blocks(),
            misses: &self.misses,
            lights: &self.lights,
            keys: &self.keys,
            samples: &self.samples,
            round,
            sample_count: samples,
        }
    }
}
