//! The measurement: all cells in turn, over and over, so that drift affects all of them alike.

use std::{borrow::Cow, path::PathBuf, sync::Arc, time::Instant};

use super::{Buffers, BuildRow, Cell, RayKind, Report, tracer::Tracer};
use crate::{
    accel::{self, AccelKind, Accelerator, BuildOptions, RayCost},
    error::Blame,
    geometry::{BuildError, Geometry},
    math::{Ray, parallel, sorting},
    native::{Embree, EmbreeError, EmbreeQuality},
    simd::Isa,
};

/// The options of a benchmark.
#[derive(Clone, Debug)]
pub struct BenchOptions {
    /// The name of the scene in the report.
    pub scene: String,
    /// The SIMD level of our accelerators.
    pub simd: Isa,
    /// The path of Embree's shared library.
    pub embree: Option<PathBuf>,
    /// Repetitions of each cell, at least 1.
    pub repetitions: usize,
    /// Repetitions of each build, at least 1.
    pub builds: usize,
}

/// Receives the progress of a benchmark.
pub trait BenchObserver {
    /// Reports step `done` of `total`.
    fn step(&self, done: usize, total: usize, what: &str);
}

/// The reason why a benchmark could not be run.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Build(#[from] BuildError),
    #[error(transparent)]
    Embree(#[from] EmbreeError),
    #[error("the camera sees nothing that could be measured")]
    NothingSeen,
}

impl Error {
    /// Who must act.
    pub fn blame(&self) -> Blame {
        match self {
            Self::Embree(_) => Blame::MissingInput,
            Self::Build(_) | Self::NothingSeen => Blame::Data,
        }
    }
}

/// The largest number of primitive tests of a linear cell in one repetition: some tenths of a
/// second.
const LINEAR_TESTS: usize = 30_000_000;

/// The results of a linear cell are compared once, on this multiple of the rays that are timed.
const LINEAR_COMPARED: usize = 8;

/// The number of rays whose cost is counted.
const COUNTED: usize = 1 << 14;

/// The number of these that a thread takes at a time.
const COUNTED_TOGETHER: usize = 1 << 8;

/// A column of the table.
struct Candidate<'a> {
    name: String,
    tracer: Tracer<'a>,
    /// Every `stride`th ray of a kind is compared.
    stride: usize,
    /// Every `timed`th ray of a kind is timed.
    timed: usize,
}

/// Measures all accelerators over `geometry` with the rays of `buffers`, on the threads of the
/// current rayon pool.
pub fn run(
    geometry: &Arc<Geometry>,
    buffers: &Buffers,
    options: &BenchOptions,
    observer: &dyn BenchObserver,
) -> Result<Report, Error> {
    if buffers.of(RayKind::Diffuse1).is_empty() {
        return Err(Error::NothingSeen);
    }
    let (build, built) = build(geometry, options, observer)?;
    let cells = trace(geometry, buffers, options, observer, &built)?;
    Ok(Report {
        scene: options.scene.clone(),
        triangles: geometry.triangles.len(),
        primitives: geometry.prim_count(),
        instances: geometry.instances.len(),
        seen: geometry.instanced_prim_count(),
        threads: rayon::current_num_threads(),
        simd: options.simd.to_string(),
        cells,
        build,
    })
}

/// A structure that was built.
enum Built {
    Ours(Box<dyn Accelerator>),
    Theirs(Embree),
}

/// The results of the last build of each name that can trace rays.
#[derive(Default)]
struct AllBuilt {
    bvh2: Option<Box<dyn Accelerator>>,
    embree: Option<Embree>,
}

/// Builds all accelerators repeatedly, and keeps those that trace rays.
fn build(
    geometry: &Arc<Geometry>,
    options: &BenchOptions,
    observer: &dyn BenchObserver,
) -> Result<(Vec<BuildRow>, AllBuilt), Error> {
    let builders = builders(geometry, options, rayon::current_num_threads());
    let mut times = vec![Vec::new(); builders.len()];
    let mut bytes = vec![None; builders.len()];
    let mut kept = AllBuilt::default();
    let steps = options.builds * builders.len();
    for repetition in 0..options.builds {
        let is_last = repetition + 1 == options.builds;
        for (i, (name, build)) in builders.iter().enumerate() {
            observer.step(repetition * builders.len() + i, steps, &format!("building {name}"));
            let start = Instant::now();
            match build()? {
                Built::Ours(accel) => {
                    times[i].push(start.elapsed().as_secs_f64() * 1e3);
                    bytes[i] = Some(accel.stats().bytes);
                    if is_last && *name == "bvh2" {
                        kept.bvh2 = Some(accel);
                    }
                }
                Built::Theirs(embree) => {
                    times[i].push(embree.build_time.as_secs_f64() * 1e3);
                    if is_last && *name == "embree-medium" {
                        kept.embree = Some(embree);
                    }
                }
            }
        }
    }
    let triangles = geometry.triangles.len() as f64;
    let per_triangle = |v: f64| (triangles > 0.0).then(|| v / triangles);
    let rows = builders.iter().zip(times.iter_mut().zip(&bytes));
    let rows = rows.map(|((name, _), (times, bytes))| {
        let ms = median(times);
        BuildRow {
            accel: (*name).to_owned(),
            ms,
            ns_per_triangle: per_triangle(ms * 1e6),
            bytes_per_triangle: bytes.and_then(|b| per_triangle(b as f64)),
        }
    });
    Ok((rows.collect(), kept))
}

type Builder<'a> = Box<dyn Fn() -> Result<Built, Error> + 'a>;

fn builders<'a>(
    geometry: &'a Arc<Geometry>,
    options: &'a BenchOptions,
    threads: usize,
) -> Vec<(&'static str, Builder<'a>)> {
    let ours = [("bvh2", AccelKind::Bvh2), ("wide", AccelKind::Wide)];
    let mut builders: Vec<(&'static str, Builder<'a>)> = Vec::new();
    for (name, kind) in ours {
        let simd = options.simd;
        let build = move || {
            Ok(Built::Ours(accel::build(
                BuildOptions { kind, simd },
                Arc::clone(geometry),
            )?))
        };
        builders.push((name, Box::new(build)));
    }
    let theirs = [
        ("embree-low", EmbreeQuality::Low),
        ("embree-medium", EmbreeQuality::Medium),
        ("embree-high", EmbreeQuality::High),
    ];
    for (name, quality) in theirs {
        let Some(library) = &options.embree else { break };
        let build = move || {
            Ok(Built::Theirs(Embree::build(
                library,
                &geometry.vertices,
                &geometry.triangles,
                quality,
                threads,
            )?))
        };
        builders.push((name, Box::new(build)));
    }
    builders
}

fn trace(
    geometry: &Arc<Geometry>,
    buffers: &Buffers,
    options: &BenchOptions,
    observer: &dyn BenchObserver,
    built: &AllBuilt,
) -> Result<Vec<Cell>, Error> {
    let all = buffers.of(RayKind::Primary).len();
    let linear = accel::build(AccelKind::Linear, Arc::clone(geometry))?;
    let wide = accel::build_wide_levels(geometry)?;
    let tests = usize::try_from(geometry.instanced_prim_count()).unwrap_or(usize::MAX);
    let timed = (LINEAR_TESTS / tests.max(1)).clamp(16, all);
    let compared = (timed * LINEAR_COMPARED).min(all);
    let ours = |name: &str, accel| Candidate {
        name: name.to_owned(),
        tracer: Tracer::Ours(accel),
        stride: 1,
        timed: 1,
    };
    let mut candidates = vec![Candidate {
        stride: all / compared,
        timed: all / timed,
        ..ours("linear", &*linear)
    }];
    candidates.extend(built.bvh2.iter().map(|accel| ours("bvh2", &**accel)));
    candidates.extend(
        wide.iter()
            .map(|(simd, accel)| ours(&format!("wide-{}", simd.name()), &**accel)),
    );
    for embree in built.embree.iter() {
        let theirs = |name: &str, tracer| Candidate {
            name: name.to_owned(),
            tracer,
            stride: 1,
            timed: 1,
        };
        candidates.push(theirs("embree1", Tracer::Embree1(embree)));
        candidates.push(theirs("embree16", Tracer::Embree16(embree, buffers)));
    }
    let mut cells = Vec::new();
    for kind in RayKind::ALL {
        let place = RayKind::ALL.len() * options.repetitions;
        let rates = measure(kind, buffers.of(kind), &candidates, options.repetitions, |repetition| {
            let done = kind as usize * options.repetitions + repetition;
            observer.step(done, place, &format!("tracing {} rays", kind.name()));
        });
        cells.extend(rates);
    }
    Ok(cells)
}

/// Measures the cells of one kind of rays.
fn measure(
    kind: RayKind,
    rays: &[Ray],
    candidates: &[Candidate<'_>],
    repetitions: usize,
    step: impl Fn(usize),
) -> Vec<Cell> {
    step(0);
    let mismatches = compare(kind, rays, candidates);
    let mut rates = vec![Vec::new(); candidates.len()];
    for repetition in 0..repetitions {
        step(repetition);
        for (c, rates) in candidates.iter().zip(&mut rates) {
            let rays = &every(c.timed, rays)[..];
            let mut prepared = c.tracer.prepare(kind, rays);
            let start = Instant::now();
            c.tracer.trace(kind, &mut prepared);
            rates.push(rays.len() as f64 / start.elapsed().as_secs_f64() / 1e6);
        }
    }
    let embree = candidates
        .iter()
        .position(|c| c.name == "embree1")
        .map(|i| median(&mut rates[i].clone()))
        .filter(|_| !rays.is_empty());
    // The wide accelerators of all SIMD levels share one tree.
    let mut of_wide = None;
    candidates
        .iter()
        .zip(rates.iter_mut().zip(mismatches))
        .map(|(c, (rates, mismatches))| {
            let mrays_per_s = median(rates);
            let (nodes, prims) = if c.name.starts_with("wide-") {
                *of_wide.get_or_insert_with(|| count(c, rays))
            } else {
                count(c, rays)
            };
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

/// Returns the number of rays on which each candidate's result differs from the reference. All
/// candidates are traced once, which also warms the caches.
fn compare(kind: RayKind, rays: &[Ray], candidates: &[Candidate<'_>]) -> Vec<u64> {
    let mut truth: Vec<Answers> = Vec::new();
    candidates
        .iter()
        .map(|c| {
            let rays = &every(c.stride, rays)[..];
            let mut prepared = c.tracer.prepare(kind, rays);
            c.tracer.trace(kind, &mut prepared);
            let answers = Answers {
                stride: c.stride,
                distances: (0..rays.len()).map(|i| prepared.distance(kind, i)).collect(),
            };
            let mismatches = truth.iter().map(|t| differences(t, &answers)).max().unwrap_or(0);
            // The linear scan is the reference for its subset of the rays. The binary tree, which
            // is compared with it, is the reference for all rays.
            if truth.len() < 2 {
                truth.push(answers);
            }
            mismatches
        })
        .collect()
}

/// Returns every `stride`th ray.
fn every(stride: usize, rays: &[Ray]) -> Cow<'_, [Ray]> {
    if stride == 1 {
        Cow::Borrowed(rays)
    } else {
        Cow::Owned(rays.iter().step_by(stride).copied().collect())
    }
}

/// The results of a candidate for every `stride`th ray.
struct Answers {
    stride: usize,
    distances: Vec<f32>,
}

/// Returns the number of rays that both traced with different results.
fn differences(truth: &Answers, answers: &Answers) -> u64 {
    let both = truth.distances.iter().enumerate().filter_map(|(i, &a)| {
        let ray = i * truth.stride;
        let at = ray.is_multiple_of(answers.stride).then_some(ray / answers.stride)?;
        Some((a, *answers.distances.get(at)?))
    });
    both.filter(|&(a, b)| !agree(a, b)).count() as u64
}

/// Returns whether two distances belong to the same hit, or to two hits that are tied; infinite
/// ones are misses.
fn agree(a: f32, b: f32) -> bool {
    a == b || (a.is_finite() && b.is_finite() && (a - b).abs() <= 1e-5 * a.abs().max(b.abs()))
}

/// Returns the nodes and primitives tested per ray, if the candidate counts them.
fn count(c: &Candidate<'_>, rays: &[Ray]) -> (Option<f64>, Option<f64>) {
    let accel = match c.tracer {
        Tracer::Ours(accel) if !rays.is_empty() => accel,
        _ => return (None, None),
    };
    let rays = every((rays.len() / COUNTED).max(c.timed).max(1), rays);
    let mut costs = vec![RayCost::default(); rays.len()];
    let batches = rays.chunks(COUNTED_TOGETHER).zip(costs.chunks_mut(COUNTED_TOGETHER));
    parallel::for_each(batches, |(rays, costs)| accel.cost(rays, costs));
    let mean = |f: fn(&RayCost) -> u32| costs.iter().map(|c| f64::from(f(c))).sum::<f64>() / rays.len() as f64;
    (Some(mean(|c| c.nodes)), Some(mean(|c| c.prims)))
}

fn median(values: &mut [f64]) -> f64 {
    sorting::sort_by(values, f64::total_cmp);
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
    fn of_no_rays_there_are_no_figures() {
        let geometry = Arc::new(Geometry::default());
        let linear = accel::build(AccelKind::Linear, geometry).expect("nothing is a scene");
        let candidates = ["linear", "embree1"].map(|name| Candidate {
            name: name.to_owned(),
            tracer: Tracer::Ours(&*linear),
            stride: 1,
            timed: 1,
        });
        for cell in measure(RayKind::Diffuse2, &[], &candidates, 1, |_| {}) {
            assert_eq!(cell.mrays_per_s, 0.0);
            assert_eq!((cell.nodes_per_ray, cell.primitives_per_ray), (None, None));
            assert_eq!(cell.ratio_to_embree1, None);
        }
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
