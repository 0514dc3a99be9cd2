//! Motion vectors: the movement of a point in the picture between two frames.

use glam::DVec3;

use crate::{camera::Camera, math::Vec3};

/// A point of a surface, and the camera that sees it there.
type Seen<'a> = (Vec3, Option<&'a Camera>);

/// The motion of a point between two pictures: pixels to the right and upwards, and metres of depth. 0 if a camera is missing or
/// does not see the point.
pub(super) fn between(from: Seen<'_>, to: Seen<'_>) -> [f32; 3] {
    let project = |(p, camera): Seen<'_>| camera.and_then(|camera| camera.project(p.as_dvec3()));
    let (Some(a), Some(b)) = (project(from), project(to)) else {
        return [0.0; 3];
    };
    let DVec3 { x, y, z } = b - a;
    // A panorama wraps around: the shorter way counts.
    let x = match to.1.and_then(Camera::period) {
        Some(period) => x - period * (x / period).round(),
        None => x,
    };
    [x, -y, z].map(|v| v as f32)
}
