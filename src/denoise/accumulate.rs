//! The mean of a frame and those around it, where they do not differ by more than their noise.

use super::{
    albedo::AlbedoMean,
    blur,
    choose::{LEAST_ERROR, OF_MEAN, error_weights},
    frame::Frame,
    layers,
    level::{levels, share},
    lighting,
    nlm::{PATCH_RADIUS, difference, weight},
    reproject::{Reprojected, reproject},
    signal::{Color, Signal},
};
use crate::{
    math::{Dispatch, VectorLoop, parallel, sorting},
    simd::Isa,
};

/// The mean of `own` and the others at its pixels, and the divisor of its light.
pub(super) fn accumulate(own: &Frame, others: &[&Frame], simd: Isa) -> (Signal, Color) {
    let pixels = own.pixels();
    // The own frame counts once.
    let mut sum = own.signal.clone();
    let own_levels = levels(&own.signal.halves, own.size);
    let mut weights = [vec![1.0; pixels], vec![1.0; pixels]];
    let mut total = vec![1.0; pixels];
    let mut layer_totals = vec![total.clone(); sum.light.len()];
    let mut albedos: Option<AlbedoMean> = None;
    for other in others {
        let Some(Reprojected {
            mut signal,
            found,
            is_still,
            mut albedo,
        }) = reproject(own, between(own, others, other), other)
        else {
            continue;
        };
        let (tested, found, kind) = match (is_still, &mut albedo) {
            (true, _) => (None, found, Kind::Still),
            (false, None) => (None, without_shifts(own, &signal, found), Kind::CameraMoves),
            (false, Some(albedo)) => {
                let plain = signal.without_layers();
                let albedos = albedos.get_or_insert_with(|| AlbedoMean::new(own));
                albedos.bring((&mut signal, albedo), &found, own.size);
                // The layers follow their own light.
                let light = std::mem::take(&mut signal.light);
                let mut tested = lighting::nearer(own, plain, &signal);
                let found = lighting::follow(own, [&mut tested, &mut signal], &found);
                signal.light = light;
                (Some(tested), found, Kind::SceneMoves)
            }
        };
        let tested = tested.as_ref().unwrap_or(&signal);
        // A path of much light in another frame must not look like that of all.
        let other_levels = levels(&tested.halves, own.size);
        let shares = own_levels
            .iter()
            .zip(&other_levels)
            .map(|(own, other)| share(*own, *other));
        let found: Vec<f32> = found.iter().zip(shares).map(|(found, share)| found * share).collect();
        // The weights by one half are those of the other.
        let by_half = [1, 0].map(|half| weights_of(own, tested, half, (&found, kind), simd));
        let pairs = || by_half[0].iter().zip(&by_half[1]);
        let both: Vec<f32> = pairs().map(|(a, b)| 0.5 * (a + b)).collect();
        if let Some((albedos, albedo)) = albedos.as_mut().zip(albedo) {
            albedos.add(&albedo, &both);
        }
        let squares: Vec<f32> = pairs().map(|(a, b)| 0.5 * (a * a + b * b)).collect();
        for half in 0..2 {
            add(&mut sum.halves[half], &signal.halves[half], &by_half[half], simd);
            add_to(&mut weights[half], &by_half[half]);
        }
        let by_layer = match own.is_of_scene_of(other) {
            true => Vec::new(),
            false => layers::follow(&own.signal.light, &mut signal.light, (&both, own.size)),
        };
        let layers = sum.light.iter_mut().zip(&mut layer_totals).zip(&signal.light);
        for (i, ((sum, total), layer)) in layers.enumerate() {
            let weights = by_layer.get(i).unwrap_or(&both);
            add(sum, layer, weights, simd);
            add_to(total, weights);
        }
        add(&mut sum.variance, &signal.variance, &squares, simd);
        add_to(&mut total, &both);
    }
    for (half, weights) in sum.halves.iter_mut().zip(&weights) {
        divide(half, weights);
    }
    for (layer, total) in sum.light.iter_mut().zip(&layer_totals) {
        divide(layer, total);
    }
    let squares: Vec<f32> = weights[0].iter().zip(&weights[1]).map(|(a, b)| a * b).collect();
    divide(&mut sum.variance, &squares);
    let modulation = match albedos {
        Some(albedos) => albedos.finish(own, &total, &mut sum),
        None => own.modulation.clone(),
    };
    (sum, modulation)
}

/// The means over patches of those pixels that are found, where the own one is.
fn mean_of_found(mut distance: Vec<f32>, found: &[f32], size: [usize; 2]) -> Vec<f32> {
    let is_found: Vec<f32> = found.iter().map(|found| f32::from(*found > 0.0)).collect();
    distance
        .iter_mut()
        .zip(&is_found)
        .for_each(|(distance, found)| *distance *= found);
    let mut means = blur::mean(&distance, size, PATCH_RADIUS);
    let parts = blur::mean(&is_found, size, PATCH_RADIUS);
    for (mean, part) in means.iter_mut().zip(parts) {
        *mean /= part.max(f32::MIN_POSITIVE);
    }
    means
}

/// What may differ between a frame and another one.
#[derive(Clone, Copy)]
enum Kind {
    /// Nothing.
    Still,
    /// The place of the camera, or the light where vectors tell of no motion.
    CameraMoves,
    /// Objects, by their motion vectors, and with them the light.
    SceneMoves,
}

/// The frames between two, in the order of the way from the own one.
fn between<'a>(own: &Frame, others: &[&'a Frame], other: &Frame) -> impl Iterator<Item = &'a Frame> {
    let (own, other) = (own.number, other.number);
    let [first, last] = [own.min(other), own.max(other)];
    let mut frames = others.to_vec();
    frames.retain(|frame| first < frame.number && frame.number < last);
    sorting::sort_by_key(&mut frames, |frame| frame.number.abs_diff(own));
    frames.into_iter()
}

/// The weight of each pixel of the other frame by what the surroundings of this half say.
fn weights_of(own: &Frame, other: &Signal, half: usize, (found, kind): (&[f32], Kind), simd: Isa) -> Vec<f32> {
    /// The difference that chance makes of patches that are alike.
    const SLACK: f32 = 1.0;
    /// The least variance, in parts of the square of the light: less is not seen.
    const LEAST: f32 = 0.02 * 0.02;
    let least = if matches!(kind, Kind::SceneMoves) { LEAST } else { 0.0 };
    let mut distance = vec![0.0; own.pixels()];
    let [width, _] = own.size;
    parallel::for_each(distance.chunks_mut(width).enumerate(), |(y, out)| {
        simd.dispatch(Difference {
            out,
            own: row(&own.signal.halves[half], y, width),
            other: row(&other.halves[half], y, width),
            own_variance: row(&own.signal.variance, y, width),
            other_variance: row(&other.variance, y, width),
            least,
        });
    });
    let mut smooth = if matches!(kind, Kind::SceneMoves) {
        mean_of_found(distance, found, own.size)
    } else {
        blur::mean(&distance, own.size, PATCH_RADIUS)
    };
    parallel::update(&mut smooth, |i, distance| {
        let weight = match kind {
            Kind::Still => still_weight(*distance),
            Kind::CameraMoves => weight(*distance),
            Kind::SceneMoves => weight(*distance - SLACK),
        };
        *distance = found[i] * weight;
    });
    smooth
}

/// The parts to which pixels are found, without those around which the light differs by more than chance explains: in its mean,
/// where it has changed by less than the noise of a pixel, or pixel by pixel, where the other frame blurs what this one shows.
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
    /// The least variance, in parts of the square of the light.
    least: f32,
}

impl VectorLoop for Difference<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.out.len();
        for c in 0..3 {
            let (a, b) = (&self.own[c][..n], &self.other[c][..n]);
            let (va, vb) = (&self.own_variance[c][..n], &self.other_variance[c][..n]);
            for x in 0..n {
                let [va, vb] = [va[x] + self.least * (a[x] * a[x]), vb[x] + self.least * (b[x] * b[x])];
                self.out[x] += difference(a[x], b[x], va, vb);
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
        let parts = sum.chunks_mut(PIXELS).zip(values.chunks(PIXELS));
        parallel::for_each(parts.zip(weights.chunks(PIXELS)), |((sum, values), weights)| {
            simd.dispatch(Add(sum, values, weights));
        });
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
