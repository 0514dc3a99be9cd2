//! A wave: thousands of paths that are traced, shaded and carried on together, until none is left.
//!
//! The order in which a sample's contributions are added depends on its own paths alone: paths stay sorted by sample,
//! and a wave that outgrows its bounds is split between samples, never within one.

use std::ops::Range;

use super::{
    Dropped, Layers, Settings,
    camera_rays::CameraRays,
    transparency::{Passing, pass, transmittance},
};
use crate::{
    accel::{Hit, RayCost, Simd},
    camera::{Camera, Shot},
    film::{PixelSum, Window},
    integrator::{Departures, Integrator, Path, Vertex, Visit, components::Sorted},
    math::{Cone, Divisor, Ray},
    sampler::{Drawn, DrawnTogether, Numbers, SampleKey, SampleKeys},
    scene::{Scene, Surface},
};

/// Paths that start together; more do not pay, fewer starve the tracer.
pub(super) const PATHS: usize = 16 * 1024;

/// Paths that go on together, where each vertex sends out several rays.
const MOST_PATHS: usize = 4 * PATHS;

/// How many vertices are answered for in a turn: few enough for the smallest cache.
const TURN: usize = 32;

/// How many vertices in advance the memory of a surface is asked for.
const AHEAD: usize = 8;

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
            simd: Simd::detect(),
            cone: scene.reads_footprints().then(cone),
        }
    }

    #[inline]
    fn visit<'b>(&'b self, path: &'b Path, ray: &'b Ray, vertex: Vertex<'b>, numbers: Numbers<'b>) -> Visit<'b> {
        Visit {
            scene: self.scene,
            path,
            ray,
            vertex,
            numbers,
            camera: &self.camera,
        }
    }
}

/// The samples of a wave: `together` of each pixel of `tile` from `first` on, a pixel's beside each other.
#[derive(Clone, Copy, Debug)]
struct Part {
    tile: Window,
    first: u32,
    together: Divisor,
    width: Divisor,
}

impl Part {
    fn new(tile: Window, samples: &Range<u32>) -> Self {
        Self {
            tile,
            first: samples.start,
            together: Divisor::new(samples.len() as u32),
            width: Divisor::new(tile.x1 - tile.x0),
        }
    }

    /// The address of the sample in `slot`.
    #[inline]
    fn key(&self, settings: &Settings, slot: u32) -> SampleKey {
        let (pixel, sample) = self.together.divide(slot);
        let (row, column) = self.width.divide(pixel);
        SampleKey {
            seed: settings.seed,
            frame: settings.frame,
            pixel: [self.tile.x0 + column, self.tile.y0 + row],
            sample: self.first + sample,
        }
    }
}

/// Vertices that are answered for one after the other.
#[derive(Default)]
struct Turn {
    surfaces: Vec<Surface>,
    keys: SampleKeys,
    drawn: DrawnTogether,
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
    rays: Vec<Ray>,
    paths: Vec<Path>,
    hits: Vec<Option<Hit>>,
    blocked: Vec<bool>,
    /// Of each shadow ray: the part of its light that arrives.
    arrives: Vec<f32>,
    passing: Passing,
    turn: Turn,
    /// The rays that met something, and those that did not.
    met: Vec<u32>,
    escaped: Vec<u32>,
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
        while !self.rays.is_empty() {
            traced.rays += self.step(job, &part);
            self.carry_on();
        }
        let together = samples.len();
        for (pixel, sum) in sums.pixels.iter_mut().enumerate() {
            for slot in pixel * together..(pixel + 1) * together {
                let l = self.out.radiance[slot];
                if l.is_finite() {
                    sum.add(l, self.alpha[slot], self.weights[slot]);
                    if let Some(sorted) = &self.out.sorted {
                        let layers = sorted.of_sample(slot);
                        let of_pixel = &mut sums.layers[pixel * layers.len()..][..layers.len()];
                        for (sum, l) in of_pixel.iter_mut().zip(layers) {
                            sum.add(*l, 0.0, self.weights[slot]);
                        }
                    }
                } else {
                    traced.dropped.note(part.key(job.settings, slot as u32).pixel);
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
        for y in tile.y0..tile.y1 {
            self.seen.look(job, y, tile.x0..tile.x1, samples);
            for (ray, &weight) in self.seen.rays.iter().zip(&self.seen.weights) {
                if let Some(ray) = ray {
                    self.rays.push(*ray);
                    self.paths.push(Path {
                        cone: job.cone.unwrap_or_default(),
                        ..Path::start(self.weights.len() as u32)
                    });
                }
                self.weights.push(weight);
                self.alpha.push(if ray.is_some() { 1.0 } else { 0.0 });
            }
        }
        self.out.sorted = match job.settings.layers {
            Layers::None => None,
            Layers::Light => Some(Sorted::new(job.scene.light_groups.names().len())),
        };
        self.out.start(self.weights.len());
    }

    /// Traces all rays, answers for all vertices, and leaves the rays that go on in `out`. Returns how many it traced.
    fn step(&mut self, job: &Job<'_>, part: &Part) -> u64 {
        let scene = job.scene;
        if job.integrator.reads_traversal() {
            return self.step_costs(job);
        }
        self.hits.clear();
        self.hits.resize(self.rays.len(), None);
        scene.accel.nearest(&self.rays, &mut self.hits);
        let mut traced = self.rays.len() as u64;
        if !job.is_opaque {
            let paths = &self.paths;
            let sample = |i: usize| (part.key(job.settings, paths[i].slot), paths[i].depth);
            traced += pass(scene, &mut self.rays, &mut self.hits, sample, &mut self.passing);
        }
        self.out.forget_rays();
        self.part_hits();
        self.answer_surfaces(job, part);
        self.answer_escapes(job, part);
        traced + self.add_unblocked(job)
    }

    /// Parts rays that met something from those that did not. Nobody can predict which do, so there is no branch.
    fn part_hits(&mut self) {
        let n = self.hits.len();
        self.met.resize(n, 0);
        self.escaped.resize(n, 0);
        let (mut met, mut escaped) = (0, 0);
        for (i, hit) in self.hits.iter().enumerate() {
            self.met[met] = i as u32;
            self.escaped[escaped] = i as u32;
            met += usize::from(hit.is_some());
            escaped += usize::from(hit.is_none());
        }
        self.met.truncate(met);
        self.escaped.truncate(escaped);
    }

    /// Answers for all vertices on surfaces.
    ///
    /// In turns of a few vertices, each of which is found, then drawn for, then answered for: steps that need not wait for
    /// each other.
    fn answer_surfaces(&mut self, job: &Job<'_>, part: &Part) {
        let (scene, integrator) = (job.scene, job.integrator);
        let Some(depth) = self.paths.first().map(|path| path.depth) else {
            return;
        };
        let purposes = integrator.draws(scene, depth);
        let hit_of = |k: usize| self.met.get(k).and_then(|&i| self.hits[i as usize].as_ref());
        let Turn { surfaces, keys, drawn } = &mut self.turn;
        for first in (0..self.met.len()).step_by(TURN) {
            let turn = first..self.met.len().min(first + TURN);
            surfaces.clear();
            keys.start(job.settings.seed, job.settings.frame);
            for k in turn.clone() {
                hit_of(k + 2 * AHEAD).inspect(|hit| scene.expect_corners(hit));
                hit_of(k + AHEAD).inspect(|hit| scene.expect_surface(hit));
                let Some(hit) = hit_of(k) else { continue };
                let i = self.met[k] as usize;
                surfaces.push(scene.surface(&self.rays[i], hit));
                let key = part.key(job.settings, self.paths[i].slot);
                keys.push(key.pixel, key.sample);
            }
            drawn.draw(job.simd, &job.settings.sampler, keys, depth, &purposes);
            for k in turn {
                let Some(hit) = hit_of(k) else { continue };
                let i = self.met[k] as usize;
                let (ray, path) = (&self.rays[i], &mut self.paths[i]);
                let surface = &mut surfaces[k - first];
                if job.cone.is_some() {
                    path.cone = path.cone.moved(surface.t * ray.d.length());
                    surface.cover(path.cone.width.abs());
                    self.out.leave_surface(path, surface);
                } else {
                    self.out.leave_from(path);
                }
                let numbers = Numbers {
                    sampler: &job.settings.sampler,
                    key: keys.get(k - first),
                    drawn: drawn.of(k - first),
                };
                let vertex = Vertex::Surface(surface, hit);
                integrator.vertex(&job.visit(path, ray, vertex, numbers), &mut self.out);
            }
        }
    }

    /// Answers for all paths that met nothing.
    fn answer_escapes(&mut self, job: &Job<'_>, part: &Part) {
        let measured = job.integrator.shown().is_measured();
        for &i in &self.escaped {
            let (ray, path) = (&self.rays[i as usize], &self.paths[i as usize]);
            if path.depth == 1 && (measured || !job.scene.background.visible) {
                self.alpha[path.slot as usize] = 0.0;
                if !measured {
                    continue;
                }
            }
            self.out.leave_from(path);
            let numbers = Numbers {
                sampler: &job.settings.sampler,
                key: part.key(job.settings, path.slot),
                drawn: Drawn::default(),
            };
            job.integrator
                .vertex(&job.visit(path, ray, Vertex::Escape, numbers), &mut self.out);
        }
    }

    /// Adds the light that shadow rays bring. Returns how many rays it traced.
    fn add_unblocked(&mut self, job: &Job<'_>) -> u64 {
        let Departures {
            shadow_rays,
            shadow_light,
            radiance,
            ..
        } = &mut self.out;
        self.blocked.clear();
        self.blocked.resize(shadow_rays.len(), false);
        job.scene.accel.occluded(shadow_rays, &mut self.blocked);
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
