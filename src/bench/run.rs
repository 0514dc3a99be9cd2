//! The measurement: every cell in turn, over and over, so that drift hits all alike.

use std::{path::PathBuf, sync::Arc, time::Instant};

use super::{
    Buffers, BuildRow, Cell, Embree, Kind, Report,
    embree::{EmbreeError, Quality as EmbreeQuality},
    tracer::Tracer,
};
use crate::{
    accel::{self, AccelKind, Accelerator, BuildError, Geometry, Quality, RayCost, Simd},
    math::Ray,
};

/// What to measure.
#[derive(Clone, Debug)]
pub struct Options {
    /// What the report calls the scene.
    pub scene: String,
    /// Embree's shared library.
    pub embree: Option<PathBuf>,
    /// Repetitions of each cell, at least 1.
    pub repetitions: usize,
    /// Repetitions of each build, at least 1.
    pub builds: usize,
}

/// Told how far a benchmark has come.
pub trait Observer {
    /// Step `done` of `total`.
    fn step(&self, done: usize, total: usize, what: &str);
}

/// Why a benchmark could not be run.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Build(#[from] BuildError),
    #[error(transparent)]
    Embree(#[from] EmbreeError),
    #[error("the camera sees nothing that could be measured")]
    NothingSeen,
}

/// Primitive tests that a linear cell may take in one repetition: some tenths of a second.
const LINEAR_TESTS: usize = 100_000_000;

/// Rays whose cost is counted.
const COUNTED: usize = 1 << 16;

/// A column of the table.
struct Contestant<'a> {
    name: String,
    tracer: Tracer<'a>,
    /// It traces every `stride`th ray of a kind.
    stride: usize,
}

/// Measures all accelerators over `geometry` with the rays of `buffers`, on the threads of the current rayon pool.
pub fn run(
    geometry: &Arc<Geometry>,
    buffers: &Buffers,
    options: &Options,
    observer: &dyn Observer,
) -> Result<Report, Error> {
    let threads = rayon::current_num_threads();
    let builds = builders(geometry, options, threads);
    let mut times = vec![Vec::new(); builds.len()];
    let mut bytes = vec![None; builds.len()];
    let steps = options.builds * builds.len();
    for repetition in 0..options.builds {
        for (i, (name, build)) in builds.iter().enumerate() {
            observer.step(repetition * builds.len() + i, steps, &format!("building {name}"));
            let (ms, size) = build()?;
            times[i].push(ms);
            bytes[i] = size;
        }
    }
    let triangles = geometry.triangles.len();
    let per_triangle = |v: f64| v / triangles.max(1) as f64;
    let build = builds
        .iter()
        .zip(times.iter_mut().zip(&bytes))
        .map(|((name, _), (times, bytes))| {
            let ms = median(times);
            BuildRow {
                accel: name.clone(),
                ms,
                ns_per_triangle: per_triangle(ms * 1e6),
                bytes_per_triangle: bytes.map(|b| per_triangle(b as f64)),
            }
        })
        .collect();
    let cells = trace(geometry, buffers, options, observer, threads)?;
    Ok(Report {
        scene: options.scene.clone(),
        triangles,
        primitives: geometry.prim_count(),
        instances: geometry.instances.len(),
        seen: geometry.seen_prim_count(),
        threads,
        simd: Simd::available().last().map_or("portable", |s| s.name()).to_owned(),
        cells,
        build,
    })
}

/// Builds once and says how long it took, in ms, and how large the result is.
type Builder<'a> = Box<dyn Fn() -> Result<(f64, Option<usize>), Error> + 'a>;

fn builders<'a>(geometry: &'a Arc<Geometry>, options: &'a Options, threads: usize) -> Vec<(String, Builder<'a>)> {
    let ours = [
        ("bvh2", AccelKind::Bvh2, Quality::default()),
        ("cwbvh", AccelKind::CwBvh, Quality::default()),
        ("wide", AccelKind::Wide, Quality::default()),
        ("wide-fast", AccelKind::Wide, Quality::Fast),
        ("wide-high", AccelKind::Wide, Quality::High),
    ];
    let mut builders: Vec<(String, Builder<'a>)> = Vec::new();
    for (name, kind, quality) in ours {
        let build = move || {
            let start = Instant::now();
            let accel = accel::build_with(kind, quality, Arc::clone(geometry))?;
            Ok((start.elapsed().as_secs_f64() * 1e3, Some(accel.stats().bytes)))
        };
        builders.push((name.to_owned(), Box::new(build)));
    }
    let theirs = [
        ("embree-low", EmbreeQuality::Low),
        ("embree-medium", EmbreeQuality::Medium),
        ("embree-high", EmbreeQuality::High),
    ];
    for (name, quality) in theirs {
        let Some(library) = &options.embree else { break };
        let build = move || {
            let embree = Embree::build(library, geometry, quality, threads)?;
            Ok((embree.build_time.as_secs_f64() * 1e3, None))
        };
        builders.push((name.to_owned(), Box::new(build)));
    }
    builders
}

fn trace(
    geometry: &Arc<Geometry>,
    buffers: &Buffers,
    options: &Options,
    observer: &dyn Observer,
    threads: usize,
) -> Result<Vec<Cell>, Error> {
    let all = buffers.of(Kind::Primary).len();
    if buffers.of(Kind::Diffuse1).is_empty() {
        return Err(Error::NothingSeen);
    }
    let build = |kind| accel::build(kind, Arc::clone(geometry));
    let (linear, bvh2, cwbvh) = (
        build(AccelKind::Linear)?,
        build(AccelKind::Bvh2)?,
        build(AccelKind::CwBvh)?,
    );
    let wide: Vec<(String, Box<dyn Accelerator>)> = Simd::available()
        .into_iter()
        .map(|simd| {
            let accel = accel::build_wide(simd, Quality::default(), Arc::clone(geometry))?;
            Ok((format!("wide-{}", simd.name()), accel))
        })
        .collect::<Result<_, BuildError>>()?;
    let embree = match &options.embree {
        Some(library) => Some(Embree::build(library, geometry, EmbreeQuality::Medium, threads)?),
        None => None,
    };
    let tests = usize::try_from(geometry.seen_prim_count()).unwrap_or(usize::MAX);
    let linear_rays = (LINEAR_TESTS / tests.max(1)).clamp(256, all);
    let ours = |name: &str, accel, stride| Contestant {
        name: name.to_owned(),
        tracer: Tracer::Ours(accel),
        stride,
    };
    let mut contestants = vec![
        ours("linear", &*linear, all / linear_rays),
        ours("bvh2", &*bvh2, 1),
        ours("cwbvh", &*cwbvh, 1),
    ];
    contestants.extend(wide.iter().map(|(name, accel)| ours(name, &**accel, 1)));
    for embree in embree.iter() {
        let theirs = |name: &str, tracer| Contestant {
            name: name.to_owned(),
            tracer,
            stride: 1,
        };
        contestants.push(theirs("embree1", Tracer::Embree1(embree)));
        contestants.push(theirs("embree16", Tracer::Embree16(embree)));
    }
    let mut cells = Vec::new();
    for kind in Kind::ALL {
        let place = Kind::ALL.len() * options.repetitions;
        let rates = measure(
            kind,
            buffers.of(kind),
            &contestants,
            options.repetitions,
            |repetition| {
                let done = kind as usize * options.repetitions + repetition;
                observer.step(done, place, &format!("tracing {} rays", kind.name()));
            },
        );
        cells.extend(rates);
    }
    Ok(cells)
}

/// The cells of one kind of rays.
fn measure(
    kind: Kind,
    rays: &[Ray],
    contestants: &[Contestant<'_>],
    repetitions: usize,
    step: impl Fn(usize),
) -> Vec<Cell> {
    let mut rates = vec![Vec::new(); contestants.len()];
    let mut mismatches = vec![0; contestants.len()];
    // One round more than is counted, for warm caches; in it the answers are compared.
    for repetition in 0..=repetitions {
        step(repetition.saturating_sub(1));
        let mut truth: Vec<Answers> = Vec::new();
        for (i, c) in contestants.iter().enumerate() {
            let own: Vec<Ray>;
            let rays = if c.stride == 1 {
                rays
            } else {
                own = rays.iter().step_by(c.stride).copied().collect();
                &own
            };
            let mut prepared = c.tracer.prepare(kind, rays);
            let start = Instant::now();
            c.tracer.trace(kind, &mut prepared);
            let seconds = start.elapsed().as_secs_f64();
            if repetition > 0 {
                rates[i].push(rays.len() as f64 / seconds / 1e6);
                continue;
            }
            let answers = Answers {
                stride: c.stride,
                distances: (0..rays.len()).map(|i| prepared.distance(kind, i)).collect(),
            };
            mismatches[i] = truth.iter().map(|t| differences(t, &answers)).max().unwrap_or(0);
            // The linear scan is the truth for its share, and the binary tree, held to it, for all rays.
            if truth.len() < 2 {
                truth.push(answers);
            }
        }
    }
    let embree = contestants
        .iter()
        .position(|c| c.name == "embree1")
        .map(|i| median(&mut rates[i].clone()));
    contestants
        .iter()
        .zip(rates.iter_mut().zip(mismatches))
        .map(|(c, (rates, mismatches))| {
            let mrays_per_s = median(rates);
            let (nodes, prims) = count(c, rays);
            Cell {
                accel: c.name.clone(),
                rays: kind.name().to_owned(),
                mrays_per_s,
                min: rates.iter().copied().fold(f64::INFINITY, f64::min),
                max: rates.iter().copied().fold(0.0, f64::max),
                ratio_to_embree1: embree.map(|e| mrays_per_s / e),
                nodes_per_ray: nodes,
                primitives_per_ray: prims,
                mismatches,
            }
        })
        .collect()
}

/// What a contestant found of every `stride`th ray.
struct Answers {
    stride: usize,
    distances: Vec<f32>,
}

/// On how many of the rays that both traced the answers differ.
fn differences(truth: &Answers, answers: &Answers) -> u64 {
    let both = truth.distances.iter().enumerate().filter_map(|(i, &a)| {
        let ray = i * truth.stride;
        let at = ray.is_multiple_of(answers.stride).then_some(ray / answers.stride)?;
        Some((a, *answers.distances.get(at)?))
    });
    both.filter(|&(a, b)| !agree(a, b)).count() as u64
}

/// Whether two distances are those of one hit, or of two that a tie explains; infinite ones are misses.
fn agree(a: f32, b: f32) -> bool {
    a == b || (a.is_finite() && b.is_finite() && (a - b).abs() <= 1e-5 * a.abs().max(b.abs()))
}

fn count(c: &Contestant<'_>, rays: &[Ray]) -> (Option<f64>, Option<f64>) {
    let Tracer::Ours(accel) = c.tracer else {
        return (None, None);
    };
    let rays: Vec<Ray> = rays
        .iter()
        .step_by((rays.len() / COUNTED).max(c.stride).max(1))
        .copied()
        .collect();
    let mut costs = vec![RayCost::default(); rays.len()];
    accel.cost(&rays, &mut costs);
    let mean = |f: fn(&RayCost) -> u32| costs.iter().map(|c| f64::from(f(c))).sum::<f64>() / rays.len().max(1) as f64;
    (Some(mean(|c| c.nodes)), Some(mean(|c| c.prims)))
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hit_never_agrees_with_a_miss() {
        assert!(agree(2.0, 2.0) && agree(f32::INFINITY, f32::INFINITY) && agree(1.0, 1.000_001));
        assert!(!agree(2.0, f32::INFINITY) && !agree(f32::INFINITY, 2.0) && !agree(1.0, 1.001));
        assert!(!agree(-1.0, f32::INFINITY));
    }

    #[test]
    fn answers_are_compared_ray_by_ray_whatever_the_strides() {
        let every = |stride: usize, distances: &[f32]| Answers {
            stride,
            distances: distances.to_vec(),
        };
        let all = every(1, &[0.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(differences(&every(2, &[0.0, 2.0, 4.0]), &all), 0);
        assert_eq!(differences(&every(2, &[0.0, 9.0, 4.0]), &all), 1);
        assert_eq!(differences(&all, &every(2, &[0.0, 2.0, 5.0])), 1);
    }
}
