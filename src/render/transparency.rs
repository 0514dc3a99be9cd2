//! Surfaces that rays pass on a straight line.
//!
//! A ray passes a surface whose object is hidden from it, a back that is culled, and a surface in a medium of higher priority. A
//! path passes any other surface with a probability of one minus its opacity; its depth, its direction and its other random numbers
//! stay the same. A shadow ray is attenuated by the opacity of the surfaces that it passes, and by the media between them. It also
//! passes surfaces that do not refract it, with their transmittance. Scenes without such surfaces have no overhead.

use std::collections::HashMap;

use crate::{
    geometry::Hit,
    integrator::{PathState, ShadowPassage},
    math::{Ray, Rgb},
    sampler::{Dimension, Independent, SampleKey},
    scene::{LitWorld, MediumStack, RayKind, Scene},
};

/// The buffers of this stage, reused between calls.
#[derive(Debug, Default)]
pub(super) struct Passing {
    /// The rays whose hits must be tested.
    asked: Vec<u32>,
    /// The rays that continue, by index and by value.
    which: Vec<u32>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    /// The start of the current segment of each shadow ray, in lengths of its direction.
    starts: Vec<f32>,
    /// The segments that paths have left behind as the medium changed, with the states of the paths there.
    passed: Vec<(Ray, PathState)>,
}

impl Passing {
    /// The segments in other media that the paths of the last [`pass`] have left behind; none in scenes without lights with a surface.
    pub fn passed(&self) -> &[(Ray, PathState)] {
        &self.passed
    }
}

/// Paths whose rays have been traced.
pub(super) struct PassingPaths<'a> {
    pub rays: &'a mut [Ray],
    pub paths: &'a mut [PathState],
    pub hits: &'a mut [Option<Hit>],
    /// The number of samples of the wave. Paths of higher numbers meet catchers alone.
    pub samples: u32,
}

/// Shadow rays that may pass surfaces.
pub(super) struct PassingShadowRays<'a> {
    pub rays: &'a mut [Ray],
    /// The sample of each ray, and its light.
    pub light: &'a [(u32, Rgb)],
    pub passages: &'a mut [ShadowPassage],
    /// The rays that meet a surface.
    pub blocked: &'a [bool],
    /// As that of [`PassingPaths`].
    pub samples: u32,
}

/// The objects that rays of a sample meet, of a wave with so many samples.
#[inline(always)]
fn world(sample: u32, samples: u32) -> LitWorld {
    if sample < samples {
        LitWorld::Whole
    } else {
        LitWorld::Catchers
    }
}

/// The surfaces that a ray has passed.
#[derive(Default)]
struct Passages {
    /// The number of random decisions so far.
    drawn: u32,
    /// The start of its current segment.
    start: f32,
}

impl Passages {
    /// Those of a ray whose segment starts at `start`.
    fn from(start: f32) -> Self {
        Self { drawn: 0, start }
    }
}

/// Continues paths behind surfaces, at random by their opacity, and behind those that are ignored. Afterwards `hits` are the final
/// hits, and a ray starts where its medium does. `key` returns the key of a sample. Returns the number of traced rays.
pub(super) fn pass(
    scene: &Scene,
    arrived: PassingPaths<'_>,
    key: impl Fn(u32) -> SampleKey,
    passing: &mut Passing,
) -> u64 {
    let PassingPaths {
        rays,
        paths,
        hits,
        samples,
    } = arrived;
    let mut traced = 0;
    let mut passages = HashMap::<u32, Passages>::new();
    passing.passed.clear();
    let has_lamps = !scene.lights.lamps().is_empty();
    passing.asked.clear();
    passing.asked.extend(0..rays.len() as u32);
    while !passing.asked.is_empty() {
        passing.which.clear();
        for &i in &passing.asked {
            let at = i as usize;
            let Some(hit) = &hits[at] else { continue };
            let (ray, path) = (&mut rays[at], &mut paths[at]);
            if scene.is_hidden(hit, path.last.bounces.ray, world(path.sample, samples)) || scene.is_culled(ray, hit) {
                passages.entry(i).or_insert_with(|| Passages::from(ray.tmin));
                ray.tmin = hit.t;
                passing.which.push(i);
                continue;
            }
            let is_displaced =
                !path.last.media.is_empty() && scene.is_displaced(path.last.media, scene.material_of(hit));
            let opacity = if is_displaced { 0.0 } else { scene.opacity(ray, hit) };
            if opacity >= 1.0 {
                continue;
            }
            let passages = passages.entry(i).or_insert_with(|| Passages::from(ray.tmin));
            if !is_displaced {
                let dimension = Dimension::transparency(path.depth, passages.drawn);
                if Independent.get_2d(&key(path.sample), dimension).x < opacity {
                    continue;
                }
                passages.drawn += 1;
            }
            let behind = behind(scene, path.last.media, ray, hit);
            if behind != path.last.media {
                if has_lamps {
                    let segment = Ray {
                        tmin: passages.start,
                        tmax: hit.t,
                        ..*ray
                    };
                    passing.passed.push((segment, *path));
                }
                let distance = (hit.t - passages.start) * ray.d.length();
                path.throughput *= scene.transmittance(path.last.media, distance);
                path.cone = path.cone.moved(distance);
                (path.last.media, passages.start) = (behind, hit.t);
            }
            ray.tmin = hit.t;
            passing.which.push(i);
        }
        trace(scene, rays, passing);
        traced += passing.which.len() as u64;
        for (&i, hit) in passing.which.iter().zip(&passing.hits) {
            hits[i as usize] = *hit;
        }
        std::mem::swap(&mut passing.asked, &mut passing.which);
    }
    for (i, passages) in passages {
        rays[i as usize].tmin = passages.start;
    }
    traced
}

/// The media on the other side of the surface at a hit.
fn behind(scene: &Scene, media: MediumStack, ray: &Ray, hit: &Hit) -> MediumStack {
    let material = scene.material_of(hit);
    if scene.shading.media.of_material(material).is_none() {
        return media;
    }
    let inwards = scene.surface(ray, hit).ng.dot(ray.d) < 0.0;
    scene.media_behind(media, material, inwards)
}

/// Computes the transmittance along shadow rays, 0 for blocked ones. Only those that meet a surface are traced.
/// Returns the number of traced rays.
pub(super) fn transmittance(
    scene: &Scene,
    shadow: PassingShadowRays<'_>,
    arrives: &mut Vec<Rgb>,
    passing: &mut Passing,
) -> u64 {
    let PassingShadowRays {
        rays,
        light,
        passages,
        blocked,
        samples,
    } = shadow;
    let mut traced = 0;
    arrives.clear();
    arrives.resize(rays.len(), Rgb::WHITE);
    passing.starts.clear();
    passing.starts.resize(rays.len(), 0.0);
    passing.which.clear();
    passing
        .which
        .extend((0..rays.len() as u32).filter(|&i| blocked[i as usize]));
    while !passing.which.is_empty() {
        trace(scene, rays, passing);
        traced += passing.which.len() as u64;
        let Passing {
            which, hits, starts, ..
        } = passing;
        let mut hits = hits.iter();
        which.retain(|&i| {
            let at = i as usize;
            let Some(hit) = hits.next().expect("a ray has an answer") else {
                return false;
            };
            let (ray, passage) = (&mut rays[at], &mut passages[at]);
            if !scene.is_hidden(hit, RayKind::Shadow, world(light[at].0, samples)) && !scene.is_culled(ray, hit) {
                arrives[at] *= through(scene, ray, hit, passage, &mut starts[at]);
            }
            ray.tmin = hit.t;
            !arrives[at].is_black()
        });
    }
    for (((arrives, ray), passage), start) in arrives.iter_mut().zip(&*rays).zip(&*passages).zip(&passing.starts) {
        if !passage.media.is_empty() && !arrives.is_black() {
            *arrives *= scene.transmittance(passage.media, (ray.tmax - start) * ray.d.length());
        }
    }
    traced
}

/// The transmittance of a shadow ray from `start`, the start of its segment, through the surface at a hit.
fn through(scene: &Scene, ray: &Ray, hit: &Hit, passage: &mut ShadowPassage, start: &mut f32) -> Rgb {
    let material = scene.material_of(hit);
    let passed = if scene.is_displaced(passage.media, material) {
        Rgb::WHITE
    } else {
        let opacity = scene.opacity(ray, hit).clamp(0.0, 1.0);
        let mut passed = Rgb::gray(1.0 - opacity);
        if opacity > 0.0 && passage.surfaces > 0 && !scene.is_black_back(ray, hit) {
            let straight = scene.straight_transmittance(ray, hit, passage.media);
            if !straight.is_black() {
                passage.surfaces -= 1;
                passed += straight * opacity;
            }
        }
        passed
    };
    if passed.is_black() {
        return passed;
    }
    let behind = behind(scene, passage.media, ray, hit);
    if behind == passage.media {
        return passed;
    }
    let distance = (hit.t - *start) * ray.d.length();
    let arrives = scene.transmittance(passage.media, distance);
    (passage.media, *start) = (behind, hit.t);
    passed * arrives
}

/// Traces the continued rays.
fn trace(scene: &Scene, rays: &[Ray], passing: &mut Passing) {
    passing.rays.clear();
    passing.rays.extend(passing.which.iter().map(|&i| rays[i as usize]));
    passing.hits.clear();
    passing.hits.resize(passing.rays.len(), None);
    scene.geometry.accel.nearest(&passing.rays, &mut passing.hits);
}
