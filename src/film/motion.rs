//! Motion vectors: the movement of a point in the picture between two frames.

use glam::DVec3;

use super::pass_spec::PassContext;
use crate::{camera::PictureCamera, scene::PointMotion};

/// The frame of a picture: the one that is rendered, or one of its neighbours.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum PictureTime {
    Before,
    Now,
    After,
}

/// The motion of a point between two pictures: pixels to the right and upwards, and metres of depth. 0 if a camera is missing or
/// does not see the point.
pub(super) fn between(context: &PassContext<'_>, points: &PointMotion, times: [PictureTime; 2]) -> [f32; 3] {
    let [Some(from), Some(to)] = times.map(|time| project(context, points, time)) else {
        return [0.0; 3];
    };
    let DVec3 { x, y, z } = to - from;
    // A panorama wraps around: the shorter way counts.
    let x = match context.camera.period() {
        Some(period) => x - period * (x / period).round(),
        None => x,
    };
    [x, -y, z].map(|v| v as f32)
}

/// The place of the point in the picture of a time. Between the openings of shutters it moves straight and at an even rate.
fn project(context: &PassContext<'_>, points: &PointMotion, time: PictureTime) -> Option<DVec3> {
    let camera = context.frame_camera;
    let neighbours = camera.neighbours();
    let cameras: &PictureCamera = match time {
        PictureTime::Before => neighbours.previous.as_ref()?,
        PictureTime::Now => camera.cameras(),
        PictureTime::After => neighbours.next.as_ref()?,
    };
    let timing = camera.timing();
    let [before, now, after] = [points.before, points.now, points.after].map(|p| p.as_dvec3());
    let [opened_before, opens_after] = camera.openings_around();
    let (start, rate) = match time {
        PictureTime::Before => (before, (now - before) / (timing.shutter.open - opened_before)),
        PictureTime::Now if neighbours.next.is_none() => (now, (now - before) / (timing.shutter.open - opened_before)),
        PictureTime::Now => (now, (after - now) / (opens_after - timing.shutter.open)),
        PictureTime::After => (after, (after - now) / (opens_after - timing.shutter.open)),
    };
    let point = |u: f64| match timing.readout.is_global() {
        true => start,
        false => start + rate * (u * timing.duration()),
    };
    cameras.project(point, (&timing, context.film))
}
