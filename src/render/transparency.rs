//! Surfaces that let a part of the light straight through: masks, blends, coloured-in foliage.
//!
//! A path passes such a surface by chance, in proportion to what it lets through, and is then where it was: the same
//! depth, the same random numbers, the same ray, which only begins later. A shadow ray is weakened by all that it
//! passes. Scenes of opaque materials alone pay nothing for this.

use std::collections::HashMap;

use crate::{
    geometry::Hit,
    math::Ray,
    sampler::{Dimension, Independent, SampleKey},
    scene::Scene,
};

/// The arrays that passing takes; they keep their memory.
#[derive(Debug, Default)]
pub(super) struct Passing {
    /// Which hits are asked whether they let their ray pass.
    asked: Vec<u32>,
    /// Which rays go on, and the rays.
    which: Vec<u32>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
}

/// Lets rays pass what chance lets them pass: `hits` are then what they really meet, and rays that passed something begin
/// behind it. `sample` names the sample and the depth of a ray. Returns how many rays it traced.
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

/// What of the light along `rays` arrives: 0 where something opaque is in the way. Asked are those that `blocked` names;
/// the others get 1. Returns how many rays it traced.
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

/// Traces the rays that go on.
fn trace(scene: &Scene, rays: &[Ray], passing: &mut Passing) {
    passing.rays.clear();
    passing.rays.extend(passing.which.iter().map(|&i| rays[i as usize]));
    passing.hits.clear();
    passing.hits.resize(passing.rays.len(), None);
    scene.accel.nearest(&passing.rays, &mut passing.hits);
}
