//! Shading without a surface: of rays that hit nothing, and of the segments before surfaces that rays pass.

use super::Wave;
use crate::{
    integrator::{Vertex, VertexContext},
    light::environment::EnvironmentLight,
    render::{Content, batch_inputs::ArrivedRays, context::RenderContext, wave::SHADE_BATCH},
    sampler::PathSampler,
};

impl Wave {
    /// Shades all paths whose rays hit nothing.
    pub(super) fn shade_misses(&mut self, context: &RenderContext<'_>) {
        let shows_background = context.shows_background();
        let is_seen = self.paths.first().is_some_and(|path| path.depth == 1);
        let is_hidden = !shows_background && is_seen;
        let backdrop = context.scene.shading.background.backdrop.filter(|_| is_seen);
        if is_hidden {
            for &i in &self.miss_indices {
                self.alpha[self.paths[i as usize].sample as usize] = 0.0;
            }
            // The camera may see lights before it.
            if context.scene.lights.lamps().is_empty() || context.settings.content != Content::Light {
                return;
            }
        }
        let Self {
            rays,
            paths,
            hits,
            miss_indices,
            inputs,
            out,
            weights,
            ..
        } = self;
        inputs.surfaces.interactions.clear();
        inputs.keys.start(context.settings.seed, context.settings.noise_frame);
        inputs.samples.clear();
        inputs.lights.clear();
        for indices in miss_indices.chunks(SHADE_BATCH) {
            let directions = indices.iter().map(|&i| rays[i as usize].d);
            let background = &context.scene.shading.background.radiance;
            background.look_up(context.simd, directions, &mut inputs.misses);
            if is_hidden {
                inputs.misses.fill(EnvironmentLight::default());
            } else if let Some(radiance) = backdrop {
                inputs.misses.fill(EnvironmentLight { radiance, pdf: 0.0 });
            }
            let arrived = ArrivedRays {
                rays,
                paths,
                hits,
                samples: weights.len() as u32,
                round: 0,
            };
            let batch = inputs.batch(context, arrived, indices);
            context.integrator.shade_batch(&batch, out);
        }
    }

    /// Shades the segments in other media that paths have left behind, which may meet lights with a surface.
    pub(super) fn shade_passed(&mut self, context: &RenderContext<'_>) {
        if !context.paths_pass || context.settings.content != Content::Light {
            return;
        }
        let Self {
            passing,
            inputs,
            out,
            weights,
            ..
        } = self;
        for (ray, path) in passing.passed() {
            out.begin_vertex(path);
            let vertex = VertexContext {
                scene: context.scene,
                path,
                ray,
                vertex: Vertex::Miss(&EnvironmentLight::default()),
                numbers: PathSampler {
                    sampler: &context.settings.sampler,
                    keys: &inputs.keys,
                    batch: &inputs.samples,
                    index: 0,
                },
                lights: &inputs.lights,
                camera: &context.camera,
                round: 0,
                sample_count: weights.len() as u32,
            };
            context.integrator.vertex(&vertex, out);
        }
    }
}
