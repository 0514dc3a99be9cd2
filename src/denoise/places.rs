//! The pixels of a frame around a place, and its values there.

use super::{
    frame::{Frame, Guides},
    projection::Place,
};

/// Four pixels of the other frame with their weights, which sum to 1; no weight where nothing fits.
pub(super) type Taps = [(u32, f32); 4];

/// The place of the middle of pixel `i` in the whole picture.
pub(super) fn of(frame: &Frame, i: usize) -> Place {
    let [width, _] = frame.size;
    Place {
        x: f64::from(frame.origin[0]) + (i % width) as f64 + 0.5,
        y: f64::from(frame.origin[1]) + (i / width) as f64 + 0.5,
        depth: 1.0 / f64::from(frame.guides.inverse_depth[i].max(1e-10)),
    }
}

/// Whether the camera rests.
pub(super) fn rests(own: &Frame, other: &Frame) -> bool {
    let window = |frame: &Frame| (frame.origin, frame.resolution);
    own.camera.is_some() && own.camera == other.camera && window(own) == window(other)
}

/// The value of a plane between pixels by a cubic that passes through their values; `None` where the 4 x 4 pixels around show other
/// objects than `like`. Source: Catmull and Rom, "A class of local interpolating splines", 1974,
/// doi:10.1016/B978-0-12-079050-0.50020-5.
pub(super) fn cubic(frame: &Frame, place: Place, plane: &[f32], like: usize) -> Option<f32> {
    let (x, y) = (
        place.x - f64::from(frame.origin[0]) - 0.5,
        place.y - f64::from(frame.origin[1]) - 0.5,
    );
    let [width, height] = frame.size;
    let fits = |at: f64, size: usize| at >= 1.0 && at < size as f64 - 2.0;
    if !fits(x, width) || !fits(y, height) {
        return None;
    }
    let weights = |t: f32| {
        let (t2, t3) = (t * t, t * t * t);
        [
            0.5 * (2.0 * t2 - t - t3),
            0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
            0.5 * (t + 4.0 * t2 - 3.0 * t3),
            0.5 * (t3 - t2),
        ]
    };
    let (u, v) = (weights(x.fract() as f32), weights(y.fract() as f32));
    let (left, top) = (x as usize - 1, y as usize - 1);
    let object = frame.guides.object.as_ref();
    let mut sum = 0.0;
    let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
    for (row, v) in v.into_iter().enumerate() {
        for (column, u) in u.into_iter().enumerate() {
            let i = (top + row) * width + left + column;
            if object.is_some_and(|object| object[i] != object[like]) {
                return None;
            }
            (least, most) = (least.min(plane[i]), most.max(plane[i]));
            sum += u * v * plane[i];
        }
    }
    Some(sum.clamp(least, most))
}

/// The four pixels of a frame around a place, as far as they fit.
pub(super) fn around(frame: &Frame, place: Place, fits: impl Fn(usize) -> bool) -> Taps {
    /// The least part of the weights that must fit.
    const LEAST: f32 = 0.1;
    let mut taps = [(0, 0.0); 4];
    let (x, y) = (
        place.x - f64::from(frame.origin[0]) - 0.5,
        place.y - f64::from(frame.origin[1]) - 0.5,
    );
    let (x0, y0) = (x.floor(), y.floor());
    let (u, v) = ((x - x0) as f32, (y - y0) as f32);
    let mut sum = 0.0;
    for (k, tap) in taps.iter_mut().enumerate() {
        let (dx, dy) = (k % 2, k / 2);
        let (column, row) = (x0 + dx as f64, y0 + dy as f64);
        let is_inside = |at: f64, size: usize| at >= 0.0 && at < size as f64;
        if !is_inside(column, frame.size[0]) || !is_inside(row, frame.size[1]) {
            continue;
        }
        let at = row as usize * frame.size[0] + column as usize;
        if fits(at) {
            let along = |at: usize, part: f32| if at == 0 { 1.0 - part } else { part };
            *tap = (at as u32, along(dx, u) * along(dy, v));
            sum += tap.1;
        }
    }
    let scale = if sum >= LEAST { 1.0 / sum } else { 0.0 };
    for tap in &mut taps {
        tap.1 *= scale;
    }
    taps
}

/// Whether pixel `j` of another frame has the inverse depth that is expected there of pixel `i`.
pub(super) fn has_depth((a, i): (&Guides, usize), (b, j): (&Guides, usize), inverse_depth: f32) -> bool {
    /// The part by which depths may differ.
    const DEPTH: f32 = 0.03;
    let depth = b.inverse_depth[j] - inverse_depth;
    let noise = a.inverse_depth_variance[i] + b.inverse_depth_variance[j];
    let most = DEPTH * b.inverse_depth[j].max(inverse_depth);
    depth * depth <= most * most + 4.0 * noise
}
