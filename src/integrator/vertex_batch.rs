//! Batches of vertices.

use super::{Integrator, PathState, ShadingOutput, Vertex, VertexContext};
use crate::{
    camera::Camera,
    geometry::Hit,
    light::environment::EnvironmentLight,
    math::Ray,
    sampler::{PathSampler, SampleBatch, SampleKeys, Sampler},
    scene::{FamilyBlock, LightFamily, LightSamples, Scene, SurfaceInteraction, surface_soa::SoaBlock},
};

/// Vertices that are shaded together: all of them on surfaces, or all of them misses.
pub struct VertexBatch<'a> {
    pub scene: &'a Scene,
    /// The camera of the paths.
    pub camera: &'a Camera,
    pub sampler: &'a Sampler,
    /// The arriving ray, the state and the hit of all paths of the wave.
    pub rays: &'a [Ray],
    pub paths: &'a [PathState],
    pub hits: &'a [Option<Hit>],
    /// The indices of the batch's paths in the wave.
    pub indices: &'a [u32],
    /// The surface of each path of the batch; empty for misses.
    pub surfaces: &'a [SurfaceInteraction],
    /// The geometry of the surfaces, in blocks.
    pub blocks: &'a [SoaBlock],
    /// The light of the background for each miss.
    pub misses: &'a [EnvironmentLight],
    /// The light samples for the surfaces.
    pub lights: &'a LightSamples,
    pub keys: &'a SampleKeys,
    pub samples: &'a SampleBatch,
    /// The round of shadow rays, from 0.
    pub round: u32,
    /// The number of samples of the wave. Paths of higher numbers meet catchers alone.
    pub sample_count: u32,
}

impl<'a> VertexBatch<'a> {
    /// The number of vertices.
    pub(super) fn len(&self) -> usize {
        self.indices.len()
    }

    /// The light samples of each family for a block of the surfaces; `None` if none were drawn.
    pub(super) fn families(&self, block: usize) -> Option<[Option<&'a FamilyBlock>; LightFamily::ALL.len()]> {
        let mut all = [None; LightFamily::ALL.len()];
        for (light, family) in all.iter_mut().zip(self.scene.lights.families()) {
            *light = Some(self.lights.of(family).get(block)?);
        }
        Some(all)
    }

    /// The context of the `k`th vertex.
    #[inline(always)]
    fn context(&self, k: usize) -> VertexContext<'_> {
        let i = self.indices[k] as usize;
        let vertex = match (self.surfaces.get(k), &self.hits[i]) {
            (Some(surface), Some(hit)) => Vertex::Surface(surface, hit),
            _ => Vertex::Miss(&self.misses[k]),
        };
        VertexContext {
            scene: self.scene,
            path: &self.paths[i],
            ray: &self.rays[i],
            vertex,
            numbers: PathSampler {
                sampler: self.sampler,
                keys: self.keys,
                batch: self.samples,
                index: k,
            },
            lights: self.lights,
            camera: self.camera,
            round: self.round,
            sample_count: self.sample_count,
        }
    }

    /// Starts the `k`th vertex and returns its context.
    #[inline(always)]
    pub(super) fn begin(&self, k: usize, out: &mut ShadingOutput) -> VertexContext<'_> {
        let context = self.context(k);
        match context.vertex {
            Vertex::Surface(surface, hit) => {
                out.begin_surface_vertex(context.path, surface);
                if let Some(contact) = self.scene.contact(surface, hit) {
                    out.set_contact(contact);
                }
            }
            Vertex::Miss(_) => out.begin_vertex(context.path),
        }
        context
    }

    /// Shades each vertex with `integrator`.
    #[inline(always)]
    pub(super) fn shade(&self, integrator: &(impl Integrator + ?Sized), out: &mut ShadingOutput) {
        for k in 0..self.len() {
            let context = self.begin(k, out);
            integrator.vertex(&context, out);
        }
    }
}
