//! Waves: thousands of paths that are traced, shaded and continued together until none is left.
//!
//! The order in which a sample's contributions are added depends on its own paths alone: paths stay sorted by sample, and a
//! wave that grows too large is split between samples, never within one.

mod grouping;
mod misses;
mod roles;
mod shadow_rays;
mod sweep;

use grouping::HitGrouping;

use super::{
    Cancelled, Content, Control, InvalidSamples,
    batch_inputs::{ArrivedRays, BatchInputs},
    camera_rays::CameraRays,
    context::RenderContext,
    sample_block::SampleBlock,
    schedule::{BlockSpec, WAVE_SIZE},
    transparency::{Passing, PassingPaths, pass},
    wave_stats::WaveStats,
};
use crate::{
    accel::{self, RayCost},
    film::TileAccumulator,
    geometry::{Hit, PrimId},
    integrator::{PathState, ShadingOutput, Stage, light_layers::LightLayers},
    math::{Ray, Rgb},
    sampler::{Dimension, PathSampler, SampleKeys, SampleUse},
    scene::FirstHit,
};

/// The most paths that are continued together, where vertices spawn several rays.
const MAX_PATHS: usize = 4 * WAVE_SIZE;

/// The number of vertices that are shaded together: many for what is done once a batch, and few enough for the second cache. Half
/// and an eighth of it take 2 and 6 % longer.
const SHADE_BATCH: usize = 256;

/// The arrays of a wave; their memory is reused from tile to tile.
#[derive(Default)]
pub(super) struct Wave {
    camera_rays: CameraRays,
    /// The active rays, and the path of each; there may be more paths.
    rays: Vec<Ray>,
    paths: Vec<PathState>,
    /// The paths of camera rays.
    camera_paths: Vec<PathState>,
    hits: Vec<Option<Hit>>,
    blocked: Vec<bool>,
    /// The transmittance of each shadow ray.
    visible: Vec<Rgb>,
    passing: Passing,
    inputs: BatchInputs,
    /// The indices of the rays with a hit, and of those without.
    hit_indices: Vec<u32>,
    miss_indices: Vec<u32>,
    /// The primitives that were hit.
    prims: Vec<PrimId>,
    grouping: HitGrouping,
    out: ShadingOutput,
    /// The filter weight and the alpha of each sample.
    weights: Vec<f32>,
    alpha: Vec<f32>,
    /// Whether each sample meets a shadow catcher; empty if the scene has none.
    is_caught: Vec<bool>,
    /// The squared distance from the pixel's centre and the first hit of each sample; empty if no pass needs them.
    distances_squared: Vec<f32>,
    first_hits: Vec<Option<FirstHit>>,
    /// Paths that wait because the wave is too large.
    waiting: Vec<(Vec<Ray>, Vec<PathState>)>,
    /// The samples of a moment.
    listed: SampleKeys,
}

impl Wave {
    /// Renders the samples of a block and adds them to the accumulator of its tile.
    ///
    /// # Errors
    /// [`Cancelled`] if `control` was cancelled; drop the wave then.
    pub fn run(
        &mut self,
        context: &RenderContext<'_>,
        spec: &BlockSpec,
        accumulator: &mut TileAccumulator,
        control: &Control<'_>,
    ) -> Result<WaveStats, Cancelled> {
        let mut stats = WaveStats::default();
        self.out.clock.start(control.stages.is_some());
        self.start(context, spec);
        self.trace(context, &SampleBlock::new(spec), control, &mut stats)?;
        self.accumulate(context, spec, accumulator, &mut stats.invalid);
        self.end(control, &stats);
        Ok(stats)
    }

    /// Traces the camera rays, and shades and continues their paths until none is left.
    fn trace(
        &mut self,
        context: &RenderContext<'_>,
        block: &SampleBlock<'_>,
        control: &Control<'_>,
        stats: &mut WaveStats,
    ) -> Result<(), Cancelled> {
        self.out.clock.lap(Stage::CameraRays);
        if context.fills_film {
            // Before the first hit, paths differ only by their samples, and are the same for every tile.
            std::mem::swap(&mut self.paths, &mut self.camera_paths);
            stats.segments += self.rays.len() as u64;
            let traced = self.step(context, block, control);
            std::mem::swap(&mut self.paths, &mut self.camera_paths);
            if context.has_catchers {
                self.camera_paths.truncate(self.weights.len());
            }
            stats.rays += traced?;
            self.compact();
        }
        while !self.rays.is_empty() {
            stats.segments += self.rays.len() as u64;
            stats.rays += self.step(context, block, control)?;
            self.compact();
        }
        Ok(())
    }

    /// Reports the times of the stages.
    fn end(&mut self, control: &Control<'_>, stats: &WaveStats) {
        self.out.clock.lap(Stage::Film);
        if let Some(times) = control.stages {
            times.add(&self.out.clock, stats.segments);
        }
    }

    /// Adds the finished samples, pixel by pixel.
    fn accumulate(
        &self,
        context: &RenderContext<'_>,
        spec: &BlockSpec,
        accumulator: &mut TileAccumulator,
        invalid: &mut InvalidSamples,
    ) {
        let (tile, together) = (spec.tile, spec.samples.len());
        let passes = context.passes();
        let record = |sample: usize| self.record(context, sample, spec.samples.start + (sample % together) as u32);
        for pixel in 0..tile.area() {
            let samples = (pixel * together..(pixel + 1) * together).map(record);
            let place = || tile.place(pixel);
            let own = context.opening_for(place);
            let count = accumulator.add(context.accumulators, &passes.with_camera(own.as_ref()), pixel, samples);
            if count > 0 {
                invalid.count_pixel(place(), count);
            }
        }
    }

    /// Generates camera rays for all samples of all pixels; the samples of a pixel are adjacent.
    fn start(&mut self, context: &RenderContext<'_>, spec: &BlockSpec) {
        self.clear();
        for y in spec.tile.y0..spec.tile.y1 {
            let first = self.rays.len();
            self.camera_rays.generate(context, spec, y, &mut self.rays);
            self.start_samples(context, first);
        }
        self.start_paths(context);
    }

    fn clear(&mut self) {
        self.rays.clear();
        self.paths.clear();
        self.weights.clear();
        self.alpha.clear();
        self.distances_squared.clear();
    }

    /// Takes the samples that camera rays were generated for, of which `first` is the first ray. Where not all of them have a
    /// ray, those that have one get their paths.
    fn start_samples(&mut self, context: &RenderContext<'_>, first: usize) {
        let sample = self.weights.len() as u32;
        self.weights.extend_from_slice(&self.camera_rays.weights);
        if context.needs.first_hits {
            self.camera_rays.distances_squared(&mut self.distances_squared);
        }
        if context.fills_film {
            return;
        }
        let mut kept = first;
        for (i, sample) in (first..).zip(sample..self.weights.len() as u32) {
            let ray = self.rays[i];
            self.alpha.push(if ray.is_none() { 0.0 } else { 1.0 });
            if !ray.is_none() {
                self.rays[kept] = ray;
                self.paths.push(context.path(sample));
                kept += 1;
            }
        }
        self.rays.truncate(kept);
    }

    /// Makes the paths of the camera rays where every sample has one, and the arrays of the frame's passes.
    fn start_paths(&mut self, context: &RenderContext<'_>) {
        if context.fills_film {
            self.alpha.resize(self.weights.len(), 1.0);
            // Cones have grown since the last tile, and paths have passed surfaces.
            let have_changed = context.cone.is_some() || context.paths_pass;
            if have_changed || self.camera_paths.first().is_some_and(|other| *other != context.path(0)) {
                self.camera_paths.clear();
            }
            let more = self.camera_paths.len() as u32..self.weights.len() as u32;
            self.camera_paths.extend(more.map(|sample| context.path(sample)));
        }
        self.start_passes(context);
        self.inputs.lights.start();
        self.is_caught.clear();
        let mut samples = self.weights.len();
        if context.has_catchers {
            self.is_caught.resize(samples, false);
            samples *= 2 + usize::from(context.shows_plate());
        }
        self.out
            .start(samples, context.cone.is_some(), context.shadow_rays_pass);
    }

    /// Allocates the arrays that the frame's passes need.
    fn start_passes(&mut self, context: &RenderContext<'_>) {
        self.first_hits.clear();
        if context.needs.first_hits {
            self.first_hits.resize(self.weights.len(), None);
        }
        let layer_count = context.scene.shading.light_groups.layer_count();
        let stays = self.out.layers.as_ref().is_some_and(|l| l.layer_count() == layer_count);
        match (context.needs.light_layers, stays) {
            (false, _) => self.out.layers = None,
            (true, true) => {}
            (true, false) => self.out.layers = Some(LightLayers::new(layer_count)),
        }
    }

    /// Traces all rays and shades all vertices; the spawned rays are in `out`. Returns the number of traced rays.
    ///
    /// # Errors
    /// [`Cancelled`] if `control` was cancelled.
    fn step(
        &mut self,
        context: &RenderContext<'_>,
        block: &SampleBlock<'_>,
        control: &Control<'_>,
    ) -> Result<u64, Cancelled> {
        let scene = context.scene;
        if context.integrator.wants_cost() {
            return Ok(self.step_costs(context));
        }
        self.hits.clear();
        self.hits.resize(self.rays.len(), None);
        let batch = accel::RayBatch {
            rays: &self.rays,
            layout: block.layout(),
        };
        scene.geometry.accel.nearest_batch(batch, &mut self.hits);
        let mut traced = self.rays.len() as u64;
        if context.paths_pass {
            let key = |sample: u32| block.key(context.settings, sample);
            let arrived = PassingPaths {
                rays: &mut self.rays,
                paths: &mut self.paths,
                hits: &mut self.hits,
                samples: self.weights.len() as u32,
            };
            traced += pass(scene, arrived, key, &mut self.passing);
        }
        self.partition_hits();
        if self.paths.first().is_some_and(|path| path.depth == 1) && scene.has_holdouts() {
            self.remove_holdouts(scene);
        }
        if context.has_catchers && self.paths.first().is_some_and(|path| path.depth == 1) {
            self.split_catchers(context);
        }
        if context.groups_hits {
            let Self {
                hits,
                hit_indices,
                prims,
                grouping,
                ..
            } = self;
            grouping.sort(scene, hits, hit_indices, prims);
        }
        self.out.clock.lap(Stage::Nearest);
        for round in 0..context.integrator.shadow_rounds() {
            if control.is_cancelled() {
                return Err(Cancelled);
            }
            self.out.clear_rays();
            self.shade_surfaces(context, block, round);
            if round == 0 {
                self.shade_misses(context);
                self.shade_passed(context);
                self.out.clock.lap(Stage::Background);
            }
            traced += self.resolve_shadow_rays(context, block.layout());
            self.out.clock.lap(Stage::Shadow);
        }
        Ok(traced)
    }

    /// Separates rays with a hit from those without. Hits are unpredictable, so there is no branch.
    fn partition_hits(&mut self) {
        let n = self.hits.len();
        self.hit_indices.resize(n, 0);
        self.prims.resize(n, PrimId::new(0));
        self.miss_indices.resize(n, 0);
        let (mut hit_count, mut miss_count) = (0, 0);
        for (i, hit) in self.hits.iter().enumerate() {
            self.hit_indices[hit_count] = i as u32;
            self.prims[hit_count] = hit.map_or(PrimId::new(0), |hit| hit.prim);
            self.miss_indices[miss_count] = i as u32;
            hit_count += usize::from(hit.is_some());
            miss_count += usize::from(hit.is_none());
        }
        self.hit_indices.truncate(hit_count);
        self.prims.truncate(hit_count);
        self.miss_indices.truncate(miss_count);
    }

    /// Shades all vertices on surfaces.
    ///
    /// Works in small batches: first the surfaces of all vertices, then their random numbers, then their shading, so that the
    /// work on different vertices overlaps in the processor.
    fn shade_surfaces(&mut self, context: &RenderContext<'_>, block: &SampleBlock<'_>, round: u32) {
        let Some(depth) = self.paths.first().map(|path| path.depth) else {
            return;
        };
        let draws = context.integrator.batched_draws(context.scene, depth);
        let Self {
            rays,
            paths,
            hits,
            hit_indices,
            prims,
            inputs,
            out,
            first_hits,
            weights,
            ..
        } = self;
        let hit = |k: usize| {
            let i = hit_indices[k] as usize;
            (&rays[i], hits[i].as_ref().expect("the ray hit something"))
        };
        for first in (0..hit_indices.len()).step_by(SHADE_BATCH) {
            let numbers = first..hit_indices.len().min(first + SHADE_BATCH);
            let indices = &hit_indices[numbers.clone()];
            context
                .scene
                .surfaces(context.simd, numbers.clone(), prims, hit, &mut inputs.surfaces);
            if context.cone.is_some() {
                for (surface, &i) in inputs.surfaces.interactions.iter_mut().zip(indices) {
                    let (ray, path) = (&rays[i as usize], &mut paths[i as usize]);
                    if round == 0 {
                        path.cone = path.cone.moved(surface.t * ray.d.length());
                    }
                    let shading = &context.scene.shading;
                    if shading.is_spatially_varying(surface.material) {
                        surface.set_footprint(path.cone.width.abs(), shading.picture_size(surface.material));
                    }
                }
            }
            if depth == 1 && round == 0 && context.needs.first_hits {
                for (surface, k) in inputs.surfaces.interactions.iter().zip(numbers) {
                    let ((ray, hit), path) = (hit(k), &paths[hit_indices[k] as usize]);
                    let first = FirstHit::new(surface, hit, surface.t * ray.d.length());
                    if let Some(own) = first_hits.get_mut(path.sample as usize) {
                        *own = Some(first);
                    }
                }
            }
            if context.settings.content == Content::FirstHits {
                continue;
            }
            out.clock.lap(Stage::Surfaces);
            block.keys(context.simd, context.settings, indices, paths, &mut inputs.keys);
            let dimension = Dimension::at(depth, SampleUse::ALL[0]);
            let sampler = &context.settings.sampler;
            inputs
                .samples
                .generate(context.simd, sampler, &inputs.keys, dimension, &draws);
            inputs.blacken_backs(context.scene);
            if context.scene.shading.has_mixtures() {
                inputs.choose_materials(context, Dimension::mixture(depth));
            }
            if depth == 1 && round == 0 && context.needs.albedo {
                for (index, (surface, &i)) in inputs.surfaces.interactions.iter().zip(indices).enumerate() {
                    let path = &paths[i as usize];
                    let numbers = PathSampler {
                        sampler,
                        keys: &inputs.keys,
                        batch: &inputs.samples,
                        index,
                    };
                    let albedo = context.sample_albedo(surface, path, &numbers);
                    if let Some(Some(first)) = first_hits.get_mut(path.sample as usize) {
                        first.albedo = albedo;
                    }
                }
            }
            out.clock.lap(Stage::Numbers);
            inputs.sample_lights(context);
            out.clock.lap(Stage::Light);
            let arrived = ArrivedRays {
                rays,
                paths,
                hits,
                samples: weights.len() as u32,
                round,
            };
            let batch = inputs.batch(context, arrived, indices);
            context.integrator.shade_batch(&batch, out);
            out.clock.lap(Stage::Bsdf);
        }
    }

    /// Adds the costs of tracing the rays, and shades nothing.
    fn step_costs(&mut self, context: &RenderContext<'_>) -> u64 {
        let mut costs = vec![RayCost::default(); self.rays.len()];
        context.scene.geometry.accel.cost(&self.rays, &mut costs);
        self.out.clear_rays();
        for (path, cost) in self.paths.iter().zip(costs) {
            self.out.begin_vertex(path);
            context.integrator.add_cost(cost, &mut self.out);
        }
        self.rays.len() as u64
    }

    /// Replaces the wave's rays by the spawned ones; if there are too many, those of later samples wait.
    fn compact(&mut self) {
        std::mem::swap(&mut self.rays, &mut self.out.rays);
        std::mem::swap(&mut self.paths, &mut self.out.paths);
        if self.rays.is_empty()
            && let Some((rays, paths)) = self.waiting.pop()
        {
            (self.rays, self.paths) = (rays, paths);
        }
        if self.rays.len() > MAX_PATHS {
            let sample = self.paths[MAX_PATHS / 2].sample;
            let at = self.paths.partition_point(|p| p.sample <= sample);
            if at < self.paths.len() {
                self.waiting.push((self.rays.split_off(at), self.paths.split_off(at)));
            }
        }
    }
}
