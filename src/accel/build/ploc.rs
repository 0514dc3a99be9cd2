//! The use of obvhs: a binary tree over boxes, by PLOC and then reinsertion, on one thread.
//!
//! obvhs gets *proxies* instead of the boxes. PLOC merges two nodes if each is the other's cheapest
//! partner. If many pairs have the same cost (identical boxes, a regular grid, boxes without area
//! in a line), hardly any choice is mutual, and the time grows with the square of the count. So a
//! proxy is the box scaled to a scene of unit size, with a minimum thickness, and moved by a tiny
//! fraction of its size ([`JITTER`]) in a pseudorandom direction. That breaks all ties. Afterwards,
//! the true boxes replace the proxies.
//!
//! Source: Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy
//! Construction", 2018, <https://doi.org/10.1109/TVCG.2017.2669983>, and "Parallel Reinsertion for
//! Bounding Volume Hierarchy Optimization", 2018, <https://doi.org/10.1111/cgf.13350>.

use glam::Vec3A;
use obvhs::{
    aabb::Aabb as Box3,
    bvh2::{Bvh2, DEFAULT_MAX_STACK_DEPTH, reinsertion::ReinsertionOptimizer},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
};

use crate::math::{Aabb, hash};

/// The displacement of a proxy and its minimum thickness, relative to the longest side of its box.
const JITTER: f32 = 1.0 / 65_536.0;

/// The same for boxes that are hardly larger than the spacing of floats at their coordinates.
const JITTER_ULPS: f32 = 2.0 * f32::EPSILON;

/// A length, in units of the scene's size, whose square is far from underflow.
const MIN_LENGTH: f32 = 1.0 / (1_u64 << 40) as f32;

/// The number of reinsertion passes, and the fraction of nodes that the first one reinserts, the
/// largest ones first. Later ones reinsert fewer.
const PASSES: usize = 16;
const FIRST_FRACTION: f32 = 0.1;

/// Builds a tree over `proxies`; each leaf holds the index of one of them.
pub fn build(proxies: &[Box3]) -> Bvh2 {
    let numbers = (0..proxies.len() as u32).collect();
    let mut tree = PlocBuilder::with_capacity(proxies.len()).build(
        PlocSearchDistance::Low,
        proxies,
        numbers,
        SortPrecision::U64,
        0,
    );
    // This depth selects a stack on the heap, which panics when it is full. The fixed stack would
    // only skip a candidate.
    tree.max_depth = DEFAULT_MAX_STACK_DEPTH;
    let passes = (0..PASSES).map(|i| FIRST_FRACTION / (2 * i + 1) as f32);
    ReinsertionOptimizer::default().run(&mut tree, 1.0, Some(passes.collect()));
    tree
}

/// Returns the proxy of the box `number`; `scale` scales the scene to unit size.
pub fn proxy(bounds: &Aabb, scale: f32, number: u32) -> Box3 {
    let (min, max) = (Vec3A::from(bounds.min) * scale, Vec3A::from(bounds.max) * scale);
    let extent = (max - min).max_element();
    let magnitude = min.abs().max(max.abs()).max_element();
    let step = (extent * JITTER).max(magnitude * JITTER_ULPS);
    // Boxes that are tiny in this scene are placed side by side rather than in one place:
    // reinsertion takes long if all boxes overlap.
    let thickness = step.max(MIN_LENGTH / 128.0);
    let [x, y, z, _] = hash::pcg4d([number, 0, 0, 0]).map(hash::unit_f32);
    let shift = (Vec3A::new(x, y, z) - 0.5) * step.max(MIN_LENGTH);
    Box3::new(min + shift, (max + shift).max(min + shift + thickness))
}
