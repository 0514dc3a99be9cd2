//! Partial opacity: alpha masks, blended materials, foliage textures.
//!
//! At such a surface, a path continues behind it with a probability of one minus the opacity. It
//! keeps its depth, its random numbers and its ray, of which only `tmin` changes. A shadow ray is
//! attenuated by all surfaces that it crosses. Scenes of opaque materials have no overhead.

use std::collections::HashMap;

use crate::{
    geometry::Hit,
    math::Ray,
    sampler::{Dimension, Independent, SampleKey},
    scene::Scene,
};

/// The buffers of this stage, reused between calls.
#[derive(Debug, Default)]
pub(super) struct Passing {
    /// The rays whose hits are tested for opacity.
    asked: Vec<u32>,
    /// The rays that continue, by index and by value.
    which: Vec<u32>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
}

/// Continues rays behind surfaces at random, by their opacity. Then `hits` are the final hits, and
/// rays that passed a surface begin behind it. `sample` returns the sample and the depth of a ray.
/// Returns the number of traced rays.
pub(super) fn pass(
    scene: &Scene,
    rays: &mut [Ray],
    hits: &mut [Option<Hit>],
    sample: impl Fn(usize) -> (SampleKey, u32),
    passing: &mut Passing,
) -> u64 {
    let mut traced = 0;
    let mut passes = HashMap::<u32, u32>::new();
    passing.asked.clear();
    passing.asked.extend(0..rays.len() as u32);
    while !passing.asked.is_empty() {
        passing.which.clear();
        for &i in &passing.asked {
            let at = i as usize;
            let Some(hit) = &hits[at] else { continue };
            let opacity = scene.opacity(&rays[at], hit);
            if opacity >= 1.0 {
                continue;
            }
            let count = passes.entry(i).or_default();
            let (key, depth) = sample(at);
            let u = Independent.get_2d(&key, Dimension::transparency(depth, *count)).x;
            if u >= opacity {
                *count += 1;
                rays[at].tmin = hit.t;
                passing.which.push(i);
            }
        }
        trace(scene, rays, passing);
        traced += passing.which.len() as u64;
        for (&i, hit) in passing.which.iter().zip(&passing.hits) {
            hits[i as usize] = *hit;
        }
        std::mem::swap(&mut passing.asked, &mut passing.which);
    }
    traced
}

/// Computes the transmittance along `rays`, which is 0 if an opaque surface blocks the ray. Only
/// the rays in `blocked` are traced; the others get 1. Returns the number of traced rays.
pub(super) fn transmittance(
    scene: &Scene,
    rays: &mut [Ray],
    blocked: &[bool],
    arrives: &mut Vec<f32>,
    passing: &mut Passing,
) -> u64 {
    let mut traced = 0;
    arrives.clear();
    arrives.resize(rays.len(), 1.0);
    passing.which.clear();
    passing
        .which
        .extend((0..rays.len() as u32).filter(|&i| blocked[i as usize]));
    while !passing.which.is_empty() {
        trace(scene, rays, passing);
        traced += passing.which.len() as u64;
        let Passing { which, hits, .. } = passing;
        let mut hits = hits.iter();
        which.retain(|&i| {
            let at = i as usize;
            let Some(hit) = hits.next().expect("a ray has an answer") else {
                return false;
            };
            arrives[at] *= 1.0 - scene.opacity(&rays[at], hit).clamp(0.0, 1.0);
            rays[at].tmin = hit.t;
            arrives[at] > 0.0
        });
    }
    traced
}

/// Traces the rays that continue.
fn trace(scene: &Scene, rays: &[Ray], passing: &mut Passing) {
    passing.rays.clear();
    passing.rays.extend(passing.which.iter().map(|&i| rays[i as usize]));
    passing.hits.clear();
    passing.hits.resize(passing.rays.len(), None);
    scene.accel.nearest(&passing.rays, &mut passing.hits);
}
