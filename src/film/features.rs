//! The features of first hits that denoisers read: albedo, normal and depth.

use super::pass_spec::{Feature, PassContext};
use crate::{math::Rgb, scene::FirstHit};

/// The value of a feature for a sample with this first hit; the depth is the first of three numbers. Without a hit, albedo and
/// normal are 0 and there is no depth.
pub(super) fn value(feature: Feature, first: Option<&FirstHit>, context: &PassContext<'_>) -> Option<Rgb> {
    match feature {
        Feature::Albedo => Some(first.map_or(Rgb::BLACK, |hit| hit.albedo)),
        Feature::Normal => Some(first.map_or(Rgb::BLACK, |hit| Rgb::new(hit.ns.x, hit.ns.y, hit.ns.z))),
        Feature::Depth => first.map(|hit| Rgb::new(depth(hit, context), 0.0, 0.0)),
    }
}

/// The distance of a hit along the camera's axis, in metres; along the ray if the camera has no axis.
pub(super) fn depth(hit: &FirstHit, context: &PassContext<'_>) -> f32 {
    let cos = context.camera.axis().map(|axis| -hit.wo.dot(axis));
    cos.map_or(hit.distance, |cos| hit.distance * cos)
}
