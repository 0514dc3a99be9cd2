//! A frame brought to the pixels of another: by the cameras and the depth, with what does not fit left out.
//!
//! Where the camera rests and the scene is the same, pixels show the same. Where one of them has changed, a pixel must show the same
//! surface, and its light is tested (`accumulate`).

use rayon::prelude::*;

use super::{
    frame::Frame,
    projection::{Place, Projection},
    signal::Signal,
};

/// A frame at the pixels of another.
pub(super) struct Reprojected {
    pub signal: Signal,
    /// Whether each pixel has been found, from 0 to 1.
    pub found: Vec<f32>,
    /// Whether the camera rests and the scene is the same.
    pub is_still: bool,
}

/// Four pixels of the other frame with their weights, which sum to 1; no weight where nothing fits.
type Taps = [(u32, f32); 4];

/// The other frame at the pixels of `own`; `None` where it cannot be told where they are.
pub(super) fn reproject(own: &Frame, other: &Frame) -> Option<Reprojected> {
    if is_still(own, other) {
        return Some(Reprojected {
            signal: same_pixels(own, other),
            found: own
                .alpha
                .iter()
                .zip(&other.alpha)
                .map(|(a, b)| covered(*a, *b))
                .collect(),
            is_still: true,
        });
    }
    let rests = rests(own, other);
    let projection = if rests {
        None
    } else {
        Some(Projection::new(own, other)?)
    };
    let taps: Vec<Taps> = (0..own.pixels())
        .into_par_iter()
        .map(|i| taps(own, other, projection.as_ref(), i))
        .collect();
    let gather = |plane: &[f32], square: bool| -> Vec<f32> {
        let value = |taps: &Taps| {
            taps.iter()
                .map(|&(i, w)| if square { w * w } else { w } * plane[i as usize])
                .sum()
        };
        taps.par_iter().map(value).collect()
    };
    let covers = gather(&other.alpha, false);
    let found = (0..own.pixels())
        .map(|i| {
            // What mirrors and glass show is not at the place of their surface: where the camera moves, it is left to the own frame.
            let specular = own.specular.as_ref().filter(|_| !rests);
            covered(own.alpha[i], covers[i]) * (1.0 - specular.map_or(0.0, |specular| specular[i]))
        })
        .collect();
    let color = |color: &[Vec<f32>; 3], square| std::array::from_fn(|c| gather(&color[c], square));
    let Signal {
        halves,
        variance,
        light,
    } = &other.signal;
    Some(Reprojected {
        signal: Signal {
            halves: [color(&halves[0], false), color(&halves[1], false)],
            variance: color(variance, true),
            light: light.iter().map(|layer| color(layer, false)).collect(),
        },
        found,
        is_still: false,
    })
}

/// Whether the camera rests and the scene is the same.
pub(super) fn is_still(own: &Frame, other: &Frame) -> bool {
    rests(own, other) && own.scene.is_some() && own.scene == other.scene
}

fn rests(own: &Frame, other: &Frame) -> bool {
    let window = |frame: &Frame| (frame.origin, frame.resolution);
    own.camera.is_some() && own.camera == other.camera && window(own) == window(other)
}

/// The weight of a pixel of another frame by the alphas of both.
fn covered(own: f32, other: f32) -> f32 {
    if own > 0.0 { (other / own).min(1.0) } else { 0.0 }
}

/// The signal of the other frame in parts of the own albedo, whose noise cancels then.
fn same_pixels(own: &Frame, other: &Frame) -> Signal {
    let mut signal = other.signal.clone();
    let Signal {
        halves,
        variance,
        light,
    } = &mut signal;
    for c in 0..3 {
        let albedo = |frame: &Frame, i: usize| frame.modulation[c][i] / frame.alpha[i];
        let factor = |i: usize| {
            let is_covered = own.alpha[i] > 0.0 && other.alpha[i] > 0.0;
            if is_covered {
                albedo(other, i) / albedo(own, i)
            } else {
                0.0
            }
        };
        let factors: Vec<f32> = (0..own.pixels()).map(factor).collect();
        for color in halves.iter_mut().chain(&mut *light) {
            color[c].iter_mut().zip(&factors).for_each(|(value, by)| *value *= by);
        }
        variance[c]
            .iter_mut()
            .zip(&factors)
            .for_each(|(value, by)| *value *= by * by);
    }
    signal
}

/// The pixels of the other frame around the place of pixel `i`, as far as they show the same surface. Without a projection it is
/// the same place.
fn taps(own: &Frame, other: &Frame, projection: Option<&Projection>, i: usize) -> Taps {
    /// The least part of the weights that must fit.
    const LEAST: f32 = 0.1;
    let mut taps = [(0, 0.0); 4];
    let Some(projection) = projection else {
        let fits = shows_same(own, i, other, i, own.guides.inverse_depth[i]);
        taps[0] = (i as u32, f32::from(fits));
        return taps;
    };
    let [width, _] = own.size;
    let (column, row) = (i % width, i / width);
    let depth = 1.0 / f64::from(own.guides.inverse_depth[i].max(1e-10));
    let place = projection.place(Place {
        x: f64::from(own.origin[0]) + column as f64 + 0.5,
        y: f64::from(own.origin[1]) + row as f64 + 0.5,
        depth,
    });
    let Some(place) = place else { return taps };
    let (x, y) = (
        place.x - f64::from(other.origin[0]) - 0.5,
        place.y - f64::from(other.origin[1]) - 0.5,
    );
    let (x0, y0) = (x.floor(), y.floor());
    let (u, v) = ((x - x0) as f32, (y - y0) as f32);
    let mut sum = 0.0;
    for (k, tap) in taps.iter_mut().enumerate() {
        let (dx, dy) = (k % 2, k / 2);
        let (column, row) = (x0 + dx as f64, y0 + dy as f64);
        let is_inside = |at: f64, size: usize| at >= 0.0 && at < size as f64;
        if !is_inside(column, other.size[0]) || !is_inside(row, other.size[1]) {
            continue;
        }
        let at = row as usize * other.size[0] + column as usize;
        if shows_same(own, i, other, at, (1.0 / place.depth) as f32) {
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

/// Whether pixel `j` of the other frame shows the surface of pixel `i`, whose inverse depth from there is given.
fn shows_same(own: &Frame, i: usize, other: &Frame, j: usize, inverse_depth: f32) -> bool {
    /// The part by which depths may differ, and the squared length by which normals may.
    const DEPTH: f32 = 0.03;
    const NORMAL: f32 = 0.15;
    let (a, b) = (&own.guides, &other.guides);
    let is_same_object = match (&a.object, &b.object) {
        (Some(a), Some(b)) => a[i] == b[j],
        _ => true,
    };
    let normals: f32 = (0..3).map(|c| (a.normal[c][i] - b.normal[c][j]).powi(2)).sum();
    let depth = b.inverse_depth[j] - inverse_depth;
    let noise = a.inverse_depth_variance[i] + b.inverse_depth_variance[j];
    let most = DEPTH * b.inverse_depth[j].max(inverse_depth);
    other.alpha[j] > 0.0
        && is_same_object
        && normals <= NORMAL + 4.0 * (a.normal_variance[i] + b.normal_variance[j])
        && depth * depth <= most * most + 4.0 * noise
}
