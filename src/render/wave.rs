//! A wave: thousands of paths that are traced, shaded and carried on together, until none is left.
//!
//! The order in which a sample's contributions are added depends on its own paths alone: paths stay sorted by sample,
//! and a wave that outgrows its bounds is split between samples, never within one.

use std::ops::Range;

use super::{
    Dropped, Layers, Settings,
    camera_rays::CameraRays,
    part::Part,
    transparency::{Passing, pass, transmittance},
};
use crate::{
    accel::{BatchLayout, Hit, PrimRef, RayBatch, RayCost, Simd},
    camera::{Camera, Shot},
    film::{PixelSum, Window},
    integrator::{Departures, Integrator, Path, Turn, components::Sorted},
    math::{Cone, Ray},
    sampler::{Dimension, DrawnTogether, Purpose, SampleKeys},
    scene::{Scene, Surfaces},
};

/// Paths that start together; more do not pay, fewer starve the tracer.
pub(super) const PATHS: usize = 4 * 1024;

/// Paths that go on together, where each vertex sends out several rays.
const MOST_PATHS: usize = 4 * PATHS;

/// How many vertices are answered for in a turn: few enough for the smallest cache.
const TURN: usize = 64;

/// What a wave works for.
pub(super) struct Job<'a> {
    pub scene: &'a Scene,
    pub shot: &'a Shot,
    /// When the shutter opens.
    pub camera: Camera,
    pub integrator: &'a dyn Integrator,
    pub settings: &'a Settings,
    /// Whether everything in the scene is.
    pub is_opaque: bool,
    /// What loops run on.
    pub simd: Simd,
    /// Whether every sample has a camera ray.
    pub fills_film: bool,
    /// Of each camera ray, where a texture wants to know; `None` where all rays may be lines.
    pub cone: Option<Cone>,
}

impl<'a> Job<'a> {
    pub fn new(scene: &'a Scene, shot: &'a Shot, integrator: &'a dyn Integrator, settings: &'a Settings) -> Self {
        // A sample has its share of the pixel in the middle; other pixels are seen under no larger an angle.
        let camera = shot.camera(0.0);
        let cone = || camera.pixel_cone().shared(settings.samples);
        Self {
            scene,
            shot,
            camera,
            integrator,
            settings,
            is_opaque: scene.is_opaque(),
            simd: scene.accel.simd(),
            fills_film: shot.fills_film(),
            cone: scene.reads_footprints().then(cone),
        }
    }
}

/// What is found for vertices before they have their turn.
#[derive(Default)]
struct Found {
    surfaces: Surfaces,
    keys: SampleKeys,
    drawn: DrawnTogether,
}

/// Where the paths of a wave have arrived.
#[derive(Clone, Copy)]
struct Arrived<'a> {
    rays: &'a [Ray],
    paths: &'a [Path],
    hits: &'a [Option<Hit>],
}

impl Found {
    /// The turn of `chosen`, for whom all this was found.
    fn turn<'a>(&'a self, job: &'a Job<'_>, arrived: Arrived<'a>, chosen: &'a [u32]) -> Turn<'a> {
        let Arrived { rays, paths, hits } = arrived;
        Turn {
            scene: job.scene,
            camera: &job.camera,
            sampler: &job.settings.sampler,
            rays,
            paths,
            hits,
            chosen,
            surfaces: &self.surfaces.found,
            keys: &self.keys,
            drawn: &self.drawn,
            has_cones: job.cone.is_some(),
        }
    }
}

/// The samples of a tile's pixels so far.
pub(super) struct Sums {
    pub pixels: Vec<PixelSum>,
    /// Layer by layer for each pixel; empty where nobody asks for them.
    pub layers: Vec<PixelSum>,
}

/// What running a wave took.
#[derive(Clone, Debug, Default)]
pub(super) struct Traced {
    pub rays: u64,
    pub dropped: Dropped,
}

/// The arrays of a wave; they keep their memory from tile to tile.
#[derive(Default)]
pub(super) struct Wave {
    seen: CameraRays,
    /// With a path for each, or more paths.
    rays: Vec<Ray>,
    paths: Vec<Path>,
    /// The paths of camera rays.
    untouched: Vec<Path>,
    hits: Vec<Option<Hit>>,
    blocked: Vec<bool>,
    /// Of each shadow ray: the part of its light that arrives.
    arrives: Vec<f32>,
    passing: Passing,
    found: Found,
    /// The rays that met something, and those that did not.
    met: Vec<u32>,
    escaped: Vec<u32>,
    /// What was met.
    prims: Vec<PrimRef>,
    out: Departures,
    /// Of each sample: its filter weight, and how much of it something covers.
    weights: Vec<f32>,
    alpha: Vec<f32>,
    /// Paths that wait because the wave has outgrown its bounds.
    waiting: Vec<(Vec<Ray>, Vec<Path>)>,
}

impl Wave {
    /// Renders `samples` of every pixel of `tile` and adds them to `sums`.
    pub fn run(&mut self, job: &Job<'_>, tile: Window, samples: Range<u32>, sums: &mut Sums) -> Traced {
        let mut traced = Traced::default();
        let part = Part::new(tile, &samples);
        self.start(job, tile, &samples);
        if job.fills_film {
            // Before anything is met all paths are alike but for their samples, and the same for every tile.
            std::mem::swap(&mut self.paths, &mut self.untouched);
            traced.rays += self.step(job, &part);
            std::mem::swap(&mut self.paths, &mut self.untouched);
            self.carry_on();
        }
        while !self.rays.is_empty() {
            traced.rays += self.step(job, &part);
            self.carry_on();
        }
        let together = samples.len();
        for (pixel, sum) in sums.pixels.iter_mut().enumerate() {
            let slots = pixel * together..(pixel + 1) * together;
            let samples = self.out.radiance[slots.clone()].iter().zip(&self.alpha[slots.clone()]);
            let mut so_far = *sum;
            for (((l, alpha), weight), slot) in samples.zip(&self.weights[slots.clone()]).zip(slots) {
                if l.is_finite() {
                    so_far.add(*l, *alpha, *weight);
                } else {
                    traced.dropped.note(part.key(job.settings, slot as u32).pixel);
                }
            }
            *sum = so_far;
        }
        if let Some(sorted) = &self.out.sorted {
            for slot in (0..self.weights.len()).filter(|slot| self.out.radiance[*slot].is_finite()) {
                let layers = sorted.of_sample(slot);
                let of_pixel = &mut sums.layers[slot / together * layers.len()..][..layers.len()];
                for (sum, l) in of_pixel.iter_mut().zip(layers) {
                    sum.add(*l, 0.0, self.weights[slot]);
                }
            }
        }
        traced
    }

    /// Camera rays for all samples of all pixels, a pixel's samples beside each other.
    fn start(&mut self, job: &Job<'_>, tile: Window, samples: &Range<u32>) {
        self.rays.clear();
        self.paths.clear();
        self.weights.clear();
        self.alpha.clear();
        let cone = job.cone.unwrap_or_default();
        let path = |slot| Path {
            cone,
            ..Path::start(slot)
        };
        for y in tile.y0..tile.y1 {
            let (first, slot) = (self.rays.len(), self.weights.len() as u32);
            self.seen.look(job, y, tile.x0..tile.x1, samples, &mut self.rays);
            self.weights.extend_from_slice(&self.seen.weights);
            let slots = slot..self.weights.len() as u32;
            if job.fills_film {
                continue;
            }
            let mut seen = first;
            for (i, slot) in (first..).zip(slots) {
                let ray = self.rays[i];
                self.alpha.push(if ray.is_nowhere() { 0.0 } else { 1.0 });
                if !ray.is_nowhere() {
                    self.rays[seen] = ray;
                    self.paths.push(path(slot));
                    seen += 1;
                }
            }
            self.rays.truncate(seen);
        }
        if job.fills_film {
            self.alpha.resize(self.weights.len(), 1.0);
            // Where textures want to know them, the cones of arrived paths have grown.
            if job.cone.is_some() || self.untouched.first().is_some_and(|other| *other != path(0)) {
                self.untouched.clear();
            }
            let more = self.untouched.len() as u32..self.weights.len() as u32;
            self.untouched.extend(more.map(path));
        }
        if job.settings.layers == Layers::Light {
            let groups = job.scene.light_groups.names().len();
            self.out.sorted.get_or_insert_with(|| Sorted::new(groups));
        }
        self.out.start(self.weights.len(), job.cone.is_some());
    }

    /// Traces all rays, answers for all vertices, and leaves the rays that go on in `out`. Returns how many it traced.
    fn step(&mut self, job: &Job<'_>, part: &Part) -> u64 {
        let scene = job.scene;
        if job.integrator.reads_traversal() {
            return self.step_costs(job);
        }
        self.hits.clear();
        self.hits.resize(self.rays.len(), None);
        let batch = RayBatch {
            rays: &self.rays,
            layout: part.layout(),
        };
        scene.accel.nearest_batch(batch, &mut self.hits);
        let mut traced = self.rays.len() as u64;
        if !job.is_opaque {
            let paths = &self.paths;
            let sample = |i: usize| (part.key(job.settings, paths[i].slot), paths[i].depth);
            traced += pass(scene, &mut self.rays, &mut self.hits, sample, &mut self.passing);
        }
        self.out.forget_rays();
        self.part_hits();
        self.answer_surfaces(job, part);
        self.answer_escapes(job);
        traced + self.add_unblocked(job, part.layout())
    }

    /// Parts rays that met something from those that did not. Nobody can predict which do, so there is no branch.
    fn part_hits(&mut self) {
        let n = self.hits.len();
        self.met.resize(n, 0);
        self.prims.resize(n, PrimRef::new(0));
        self.escaped.resize(n, 0);
        let (mut met, mut escaped) = (0, 0);
        for (i, hit) in self.hits.iter().enumerate() {
            self.met[met] = i as u32;
            self.prims[met] = hit.map_or(PrimRef::new(0), |hit| hit.prim);
            self.escaped[escaped] = i as u32;
            met += usize::from(hit.is_some());
            escaped += usize::from(hit.is_none());
        }
        self.met.truncate(met);
        self.prims.truncate(met);
        self.escaped.truncate(escaped);
    }

    /// Answers for all vertices on surfaces.
    ///
    /// In turns of a few vertices, each of which is found, then drawn for, then answered for: steps that need not wait for
    /// each other.
    fn answer_surfaces(&mut self, job: &Job<'_>, part: &Part) {
        let Some(depth) = self.paths.first().map(|path| path.depth) else {
            return;
        };
        let purposes = job.integrator.draws(job.scene, depth);
        let Self {
            rays,
            paths,
            hits,
            met,
            prims,
            found,
            out,
            ..
        } = self;
        let hit = |k: usize| {
            let i = met[k] as usize;
            (&rays[i], hits[i].as_ref().expect("something was met"))
        };
        for first in (0..met.len()).step_by(TURN) {
            let numbers = first..met.len().min(first + TURN);
            let chosen = &met[numbers.clone()];
            job.scene.surfaces(job.simd, numbers, prims, hit, &mut found.surfaces);
            if job.cone.is_some() {
                for (surface, &i) in found.surfaces.found.iter_mut().zip(chosen) {
                    let (ray, path) = (&rays[i as usize], &mut paths[i as usize]);
                    path.cone = path.cone.moved(surface.t * ray.d.length());
                    surface.cover(path.cone.width.abs());
                }
            }
            part.keys(job.simd, job.settings, chosen, paths, &mut found.keys);
            let dimension = Dimension::at(depth, Purpose::ALL[0]);
            found
                .drawn
                .draw(job.simd, &job.settings.sampler, &found.keys, dimension, &purposes);
            let turn = found.turn(job, Arrived { rays, paths, hits }, chosen);
            job.integrator.turn(&turn, out);
        }
    }

    /// Answers for all paths that met nothing.
    fn answer_escapes(&mut self, job: &Job<'_>) {
        let measured = job.integrator.shown().is_measured();
        if self.paths.first().is_some_and(|path| path.depth == 1) && (measured || !job.scene.background.visible) {
            for &i in &self.escaped {
                self.alpha[self.paths[i as usize].slot as usize] = 0.0;
            }
            if !measured {
                return;
            }
        }
        let Self {
            rays,
            paths,
            hits,
            escaped,
            found,
            out,
            ..
        } = self;
        found.surfaces.found.clear();
        found.keys.start(job.settings.seed, job.settings.frame);
        found.drawn.forget();
        for chosen in escaped.chunks(TURN) {
            let turn = found.turn(job, Arrived { rays, paths, hits }, chosen);
            job.integrator.turn(&turn, out);
        }
    }

    /// Adds the light that shadow rays bring. Returns how many rays it traced.
    fn add_unblocked(&mut self, job: &Job<'_>, layout: BatchLayout) -> u64 {
        let Departures {
            shadow_rays,
            shadow_light,
            radiance,
            ..
        } = &mut self.out;
        self.blocked.clear();
        self.blocked.resize(shadow_rays.len(), false);
        let batch = RayBatch {
            rays: shadow_rays,
            layout,
        };
        job.scene.accel.occluded_batch(batch, &mut self.blocked);
        let traced = shadow_rays.len() as u64;
        if job.is_opaque {
            for (&(slot, l), _) in shadow_light.iter().zip(&self.blocked).filter(|(_, blocked)| !**blocked) {
                radiance[slot as usize] += l;
            }
            self.sort_arrived(|wave, ray| if wave.blocked[ray] { 0.0 } else { 1.0 });
            return traced;
        }
        let arrives = &mut self.arrives;
        let more = transmittance(job.scene, shadow_rays, &self.blocked, arrives, &mut self.passing);
        for (&(slot, l), &part) in shadow_light.iter().zip(&*arrives).filter(|(_, part)| **part > 0.0) {
            radiance[slot as usize] += l * part;
        }
        self.sort_arrived(|wave, ray| wave.arrives[ray]);
        traced + more
    }

    /// The light of the shadow rays once more, where it is sorted; `part` tells what of each arrives.
    fn sort_arrived(&mut self, part: impl Fn(&Self, usize) -> f32) {
        let Some(mut sorted) = self.out.sorted.take() else {
            return;
        };
        for ray in 0..self.blocked.len() {
            let arrives = part(self, ray);
            if arrives > 0.0 {
                sorted.arrive(ray, arrives);
            }
        }
        self.out.sorted = Some(sorted);
    }

    /// Asks what tracing takes, and answers for nothing else.
    fn step_costs(&mut self, job: &Job<'_>) -> u64 {
        let mut costs = vec![RayCost::default(); self.rays.len()];
        job.scene.accel.cost(&self.rays, &mut costs);
        self.out.forget_rays();
        for (path, cost) in self.paths.iter().zip(costs) {
            self.out.leave_from(path);
            job.integrator.traversal(cost, &mut self.out);
        }
        self.rays.len() as u64
    }

    /// Makes the rays that go on the wave's own; where they are too many, those of the later samples wait.
    fn carry_on(&mut self) {
        std::mem::swap(&mut self.rays, &mut self.out.rays);
        std::mem::swap(&mut self.paths, &mut self.out.paths);
        if self.rays.is_empty()
            && let Some((rays, paths)) = self.waiting.pop()
        {
            (self.rays, self.paths) = (rays, paths);
        }
        if self.rays.len() > MOST_PATHS {
            let slot = self.paths[MOST_PATHS / 2].slot;
            let at = self.paths.partition_point(|p| p.slot <= slot);
            if at < self.paths.len() {
                self.waiting.push((self.rays.split_off(at), self.paths.split_off(at)));
            }
        }
    }
}
