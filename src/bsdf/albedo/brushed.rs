//! Brushed facets, which are steeper along one axis than along the other, and their places in tables.
//!
//! Tables have nodes by the perceived roughness of even facets of the same mean square alpha and by the root of the ratio of the
//! smaller alpha to the larger one; those of a direction are by the root of a cosine and by its turn.

use super::table::{along, lerp, locate, node};
use crate::{
    bsdf::microfacet::{Facets, Ggx},
    math::{Vec2, Vec3},
};

/// The perceived roughness of even facets of the same mean square alpha.
pub(super) fn roughness(alpha: Vec2) -> f32 {
    (0.5 * alpha.length_squared()).sqrt().sqrt()
}

/// The alphas and a direction of facets that are turned so that they are steeper along x. The direction is mirrored to where
/// no coordinate is below 0.
pub(super) fn aligned(alpha: Vec2, wo: Vec3) -> (Vec2, Vec3) {
    if alpha.x < alpha.y {
        (Vec2::new(alpha.y, alpha.x), Vec3::new(wo.y, wo.x, wo.z).abs())
    } else {
        (alpha, wo.abs())
    }
}

/// A direction where the surface is stretched until its facets are as steep as those of a roughness of 1.
pub(super) fn stretched(alpha: Vec2, w: Vec3) -> Vec3 {
    (w * alpha.extend(1.0)).normalize()
}

/// The direction of which the stretched one has this cosine and turn, a unit vector in the plane.
pub(super) fn seen_from(alpha: Vec2, turn: Vec2, cos: f32) -> Vec3 {
    let stretched = (turn * (1.0 - cos * cos).sqrt()).extend(cos);
    (stretched / alpha.extend(1.0)).normalize()
}

/// The position of `x` between the second axis and the first.
pub(super) fn azimuth(x: f32, y: f32) -> f32 {
    if x + y > 0.0 { x / (x + y) } else { 0.5 }
}

/// A unit vector in the plane for which [`azimuth`] is `v`.
pub(super) fn azimuth_vector(v: f32) -> Vec2 {
    Vec2::new(v, 1.0 - v).normalize()
}

/// The facets of a node of a table of so many roughnesses and ratios. The larger alpha may be above 1, where no surface is.
pub(super) fn facets<F: Facets>(nodes: [usize; 2], i: usize, j: usize) -> F {
    let [roughnesses, ratios] = nodes;
    let roughness = node(i, roughnesses).max(0.04);
    let ratio = node(j, ratios) * node(j, ratios);
    let along = roughness * roughness * (2.0 / (1.0 + ratio * ratio)).sqrt();
    F::with_alpha(Vec2::new(along, (along * ratio).max(Ggx::MIN_ALPHA)))
}

/// Linear between the four nodes about facets of `alpha`, in a table of so many roughnesses and ratios.
pub(super) fn between<T>(
    alpha: Vec2,
    nodes: [usize; 2],
    of: impl Fn(usize, usize) -> T,
    value: impl Fn(T) -> f32,
) -> f32 {
    let (i, f) = locate(roughness(alpha), nodes[0]);
    let (j, g) = locate((alpha.min_element() / alpha.max_element()).sqrt(), nodes[1]);
    let at = |i| lerp(value(of(i, j)), value(of(i, j + 1)), g);
    lerp(at(i), at(i + 1), f)
}

/// Linear between the nodes of a table by columns and turns.
pub(super) fn lookup<const K: usize, const L: usize>(table: &[[f32; L]; K], column: f32, turn: f32) -> f32 {
    let (k, f) = locate(column, K);
    lerp(along(&table[k], turn), along(&table[k + 1], turn), f)
}
