//! The mean of a frame and those around it, where they do not differ by more than their noise.

use rayon::prelude::*;

use super::{
    blur,
    choose::{LEAST_ERROR, OF_MEAN, error_weights},
    frame::Frame,
    level::{levels, share},
    nlm::{PATCH_RADIUS, difference, weight},
    reproject::{Reprojected, reproject},
    signal::{Color, Signal},
};
use crate::{
    math::{Dispatch, VectorLoop},
    simd::Isa,
};

/// The mean of `own` and the others at its pixels.
pub(super) fn accumulate(own: &Frame, others: &[&Frame], simd: Isa) -> Signal {
    let pixels = own.pixels();
    // The own frame counts once.
    let mut sum = own.signal.clone();
    let own_levels = levels(&own.signal.halves, own.size);
    let mut weights = [vec![1.0; pixels], vec![1.0; pixels]];
    let mut total = vec![1.0; pixels];
    for other in others {
        let Some(Reprojected {
            signal,
            found,
            is_still,
        }) = reproject(own, other)
        else {
            continue;
        };
        let found = if is_still {
            found
        } else {
            without_shifts(own, &signal, found)
        };
        // A path of much light in another frame must not look like that of all.
        let other_levels = levels(&signal.halves, own.size);
        let shares = own_levels
            .iter()
            .zip(&other_levels)
            .map(|(own, other)| share(*own, *other));
        let found: Vec<f32> = found.iter().zip(shares).map(|(found, share)| found * share).collect();
        // The weights by one half are those of the other.
        let by_half = [1, 0].map(|half| weights_of(own, &signal, half, (&found, is_still), simd));
        let pairs = || by_half[0].iter().zip(&by_half[1]);
        let both: Vec<f32> = pairs().map(|(a, b)| 0.5 * (a + b)).collect();
        let squares: Vec<f32> = pairs().map(|(a, b)| 0.5 * (a * a + b * b)).collect();
        for half in 0..2 {
            add(&mut sum.halves[half], &signal.halves[half], &by_half[half], simd);
            add_to(&mut weights[half], &by_half[half]);
        }
        for (sum, layer) in sum.light.iter_mut().zip(&signal.light) {
            add(sum, layer, &both, simd);
        }
        add(&mut sum.variance, &signal.variance, &squares, simd);
        add_to(&mut total, &both);
    }
    for (half, weights) in sum.halves.iter_mut().zip(&weights) {
        divide(half, weights);
    }
    for layer in &mut sum.light {
        divide(layer, &total);
    }
    let squares: Vec<f32> = weights[0].iter().zip(&weights[1]).map(|(a, b)| a * b).collect();
    divide(&mut sum.variance, &squares);
    sum
}

/// The weight of each pixel of the other frame by what the surroundings of this half say.
fn weights_of(own: &Frame, other: &Signal, half: usize, (found, is_still): (&[f32], bool), simd: Isa) -> Vec<f32> {
    let mut distance = vec![0.0; own.pixels()];
    let [width, _] = own.size;
    distance.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        simd.dispatch(Difference {
            out,
            own: row(&own.signal.halves[half], y, width),
            other: row(&other.halves[half], y, width),
            own_variance: row(&own.signal.variance, y, width),
            other_variance: row(&other.variance, y, width),
        });
    });
    let mut smooth = blur::mean(&distance, own.size, PATCH_RADIUS);
    smooth
        .par_chunks_mut(width)
        .zip(found.par_chunks(width))
        .for_each(|(row, found)| {
            for (distance, found) in row.iter_mut().zip(found) {
                *distance = found
                    * if is_still {
                        still_weight(*distance)
                    } else {
                        weight(*distance)
                    };
            }
        });
    smooth
}

/// The parts to which pixels are found, without those around which the light differs by more than chance explains: in its mean, where it
/// has changed by less than the noise of a pixel, or pixel by pixel, where the other frame blurs what this one shows.
fn without_shifts(own: &Frame, other: &Signal, found: Vec<f32>) -> Vec<f32> {
    const RADIUS: usize = 6;
    const COUNT: f32 = ((2 * RADIUS + 1) * (2 * RADIUS + 1)) as f32;
    /// Squared differences in parts of their variance, at which weights start to fall and are 0.
    const FROM: f32 = 4.0;
    const TO: f32 = 10.0;
    /// The part of the halves' variance that is taken as the noise of their mean.
    const NOISE: f32 = 0.5 * OF_MEAN;
    let pixels = own.pixels();
    let (mut shift, mut variance) = (vec![0.0; pixels], vec![0.0; pixels]);
    let weights = error_weights(own, &own.signal.halves);
    let (mut apart, mut noise) = (vec![0.0; pixels], vec![0.0; pixels]);
    for c in 0..3 {
        let halves = [&own.signal.halves, &other.halves].map(|halves| [&halves[0][c], &halves[1][c]]);
        let mean = |frame: usize, i: usize| 0.5 * (halves[frame][0][i] + halves[frame][1][i]);
        let differences: Vec<f32> = (0..pixels).map(|i| found[i] * (mean(0, i) - mean(1, i))).collect();
        let mean = blur::mean(&differences, own.size, RADIUS);
        for i in 0..pixels {
            shift[i] += COUNT * mean[i] * mean[i];
            variance[i] += found[i] * found[i] * 0.5 * (own.signal.variance[c][i] + other.variance[c][i]);
            let halves = halves.map(|halves| halves[0][i] - halves[1][i]);
            let square: f32 = halves.iter().map(|half| half * half).sum();
            apart[i] += weights[i] * differences[i] * differences[i];
            apart[i] += found[i] * found[i] * LEAST_ERROR;
            noise[i] += weights[i] * found[i] * found[i] * NOISE * square;
        }
    }
    let [variance, apart, noise] = [variance, apart, noise].map(|plane| blur::mean(&plane, own.size, RADIUS));
    let weight = |i: usize| {
        let shift = shift[i] / variance[i].max(f32::MIN_POSITIVE);
        let explained = (noise[i] / apart[i].max(f32::MIN_POSITIVE)).min(1.0);
        found[i] * ((TO - shift) / (TO - FROM)).clamp(0.0, 1.0) * explained
    };
    (0..pixels).map(weight).collect()
}

/// The weight of a pixel at this distance where the camera stands still, so that it shows the same place: less than 1 only
/// where chance cannot explain the difference.
fn still_weight(distance: f32) -> f32 {
    const LARGE: f32 = 6.0;
    const SLOPE: f32 = 0.25;
    ((LARGE - distance) * SLOPE).clamp(0.0, 1.0)
}

/// A row of pixels.
fn row(color: &Color, y: usize, width: usize) -> [&[f32]; 3] {
    std::array::from_fn(|c| &color[c][y * width..][..width])
}

/// The differences of a row of pixels of two frames, by their noise.
struct Difference<'a> {
    out: &'a mut [f32],
    own: [&'a [f32]; 3],
    other: [&'a [f32]; 3],
    own_variance: [&'a [f32]; 3],
    other_variance: [&'a [f32]; 3],
}

impl VectorLoop for Difference<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.out.len();
        for c in 0..3 {
            let (a, b) = (&self.own[c][..n], &self.other[c][..n]);
            let (va, vb) = (&self.own_variance[c][..n], &self.other_variance[c][..n]);
            for x in 0..n {
                self.out[x] += difference(a[x], b[x], va[x], vb[x]);
            }
        }
    }
}

/// Adds a color times weights.
fn add(sum: &mut Color, color: &Color, weights: &[f32], simd: Isa) {
    struct Add<'a>(&'a mut [f32], &'a [f32], &'a [f32]);
    impl VectorLoop for Add<'_> {
        #[inline(always)]
        fn run(self) {
            for ((sum, value), weight) in self.0.iter_mut().zip(self.1).zip(self.2) {
                *sum += weight * value;
            }
        }
    }
    const PIXELS: usize = 1 << 14;
    for (sum, values) in sum.iter_mut().zip(color) {
        sum.par_chunks_mut(PIXELS)
            .zip(values.par_chunks(PIXELS))
            .zip(weights.par_chunks(PIXELS))
            .for_each(|((sum, values), weights)| simd.dispatch(Add(sum, values, weights)));
    }
}

fn add_to(sum: &mut [f32], values: &[f32]) {
    for (sum, value) in sum.iter_mut().zip(values) {
        *sum += value;
    }
}

fn divide(color: &mut Color, by: &[f32]) {
    for plane in color {
        for (value, by) in plane.iter_mut().zip(by) {
            *value /= by;
        }
    }
}
