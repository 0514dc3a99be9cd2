//! The mixture of what the windows and the noisy mean say, by their estimated errors.

use super::{
    blur,
    denoised::Denoised,
    frame::Frame,
    nlm::Filtered,
    signal::{Color, Signal, black},
};
use crate::math::parallel;

/// The halves of a run of evenly spread samples differ by more than the noise of their mean tells: they are taken to be correlated,
/// with the other sign, by so much. Measured are 0 for indirect light and 0.3 to 0.7 at the edges of textures.
const CORRELATION: f32 = 0.3;

/// The variance of a half, and of the mean of both, in parts of half of the squared difference of the halves.
const OF_HALF: f32 = 1.0 / (1.0 + CORRELATION);
pub(super) const OF_MEAN: f32 = 0.5 * (1.0 - CORRELATION) / (1.0 + CORRELATION);

/// The squared error that means over other pixels and frames have at least in each channel, in parts of the squared sum of the
/// channels: noise that is lower needs none.
pub(super) const LEAST_ERROR: f32 = (0.01 / 3.0) * (0.01 / 3.0);

/// Mixes the means of two windows with `mean`, the noisy signal that they filtered, and multiplies it.
pub(super) fn choose(own: &Frame, (mean, modulation): (&Signal, &Color), windows: &[Filtered; 2]) -> Denoised {
    let noise: Vec<f32> = (0..own.pixels()).map(|i| 0.5 * sum(&mean.variance, i)).collect();
    let weights = error_weights(own, &windows[1].halves);
    let [(errors, told), (large_errors, large_told)] =
        [0, 1].map(|w| relative_errors(mean, &weights, &windows[w].halves, own.size));
    let (errors, told) = ([errors, large_errors], [told, large_told]);
    let shares: Vec<[f32; 2]> = errors[0]
        .iter()
        .zip(&errors[1])
        .map(|(a, b)| shares([*a, *b]))
        .collect();
    let mean_of = |halves: &[Color; 2], c: usize| -> Vec<f32> {
        halves[0][c]
            .iter()
            .zip(&halves[1][c])
            .map(|(a, b)| 0.5 * (a + b))
            .collect()
    };
    let mix = |noisy: &[f32], small: &[f32], large: &[f32], modulation: &[f32]| -> Vec<f32> {
        let pixel = |i: usize| {
            let [a, b] = shares[i];
            (noisy[i] + a * (small[i] - noisy[i]) + b * (large[i] - noisy[i])) * modulation[i]
        };
        parallel::table(noisy.len(), pixel)
    };
    let beauty: Color = std::array::from_fn(|c| {
        let [small, large] = [0, 1].map(|w| mean_of(&windows[w].halves, c));
        mix(&mean_of(&mean.halves, c), &small, &large, &modulation[c])
    });
    let layer = |layer: usize| -> Color {
        std::array::from_fn(|c| {
            let [small, large] = [0, 1].map(|w| &windows[w].light[layer][c]);
            mix(&mean.light[layer][c], small, large, &modulation[c])
        })
    };
    let mut denoised = Denoised {
        beauty,
        light: (0..mean.light.len()).map(layer).collect(),
        error: None,
        alpha: None,
        is_exact: exact(own),
    };
    scale_families(own, &mut denoised);
    let mut errors_left = black(own.pixels());
    let left = [0, 1].map(|w| noise_left(&windows[w].halves, own.size));
    let ghosts = ghosts(own, mean, &noise);
    for i in 0..own.pixels() {
        let (shares, rest) = (shares[i], 1.0 - shares[i][0] - shares[i][1]);
        let mut square = rest * rest * noise[i] + ghosts[i];
        for w in 0..2 {
            square += shares[w] * (told[w][i].max(0.0) * noise[i]).max(left[w][i]);
        }
        if denoised.is_exact[i] {
            continue;
        }
        for (c, plane) in errors_left.iter_mut().enumerate() {
            // What was cut may have been true.
            let cut = own.cut[c][i];
            plane[i] = (square / 3.0 + cut * cut).sqrt() * modulation[c][i];
        }
    }
    denoised.error = Some(errors_left);
    denoised
}

/// The pixels without noise.
pub(super) fn exact(own: &Frame) -> Vec<bool> {
    (0..own.pixels()).map(|i| sum(&own.signal.variance, i) == 0.0).collect()
}

/// Makes the layers of each family sum to the beauty: weights by one half averaged the other half there, but all samples here.
pub(super) fn scale_families(own: &Frame, denoised: &mut Denoised) {
    for family in &own.families {
        scale_to_sum(own, denoised, family);
    }
}

fn scale_to_sum(own: &Frame, Denoised { beauty, light, .. }: &mut Denoised, family: &[usize]) {
    for c in 0..3 {
        // Where the layers are black, a layer gets light as it has light in the whole frame: none where its lamps are off.
        let in_frame = |layer: &usize| -> f64 {
            let pixels = own.signal.light[*layer][c].iter().zip(&own.modulation[c]);
            pixels.map(|(light, by)| f64::from(light * by)).sum::<f64>().max(0.0)
        };
        let all: f64 = family.iter().map(in_frame).sum();
        let part = |layer: &usize| {
            if all > 0.0 {
                in_frame(layer) / all
            } else {
                1.0 / family.len() as f64
            }
        };
        let parts: Vec<f32> = family.iter().map(|layer| part(layer) as f32).collect();
        for (i, beauty) in beauty[c].iter().enumerate() {
            let sum: f32 = family.iter().map(|layer| light[*layer][c][i]).sum();
            for (layer, part) in family.iter().zip(&parts) {
                let value = &mut light[*layer][c][i];
                if sum > 0.0 {
                    *value *= beauty / sum;
                } else {
                    *value += part * (beauty - sum);
                }
            }
        }
    }
}

/// The parts of the windows in the mixture; the rest is that of the noisy mean.
///
/// The windows count by one over their errors, and the noisy mean, whose error is 1, so that the error of both is the least, were
/// they independent.
fn shares(errors: [f32; 2]) -> [f32; 2] {
    /// Errors of estimated errors, for which no noise is taken in.
    const CHANCE: f32 = 0.2;
    const LEAST: f32 = 0.02;
    let errors = errors.map(|error| (error - CHANCE).max(0.0));
    let weights = errors.map(|error| 1.0 / (error + LEAST));
    let total = weights[0] + weights[1];
    let error = (weights[0] * errors[0] + weights[1] * errors[1]) / total;
    weights.map(|weight| weight / (total * (1.0 + error)))
}

fn sum(color: &Color, i: usize) -> f32 {
    color[0][i] + color[1][i] + color[2][i]
}

/// The weights of the squared errors of pixels when they are summed over those around: one over the square of the light there, so
/// that bright pixels do not outweigh dark ones.
pub(super) fn error_weights(own: &Frame, filtered: &[Color; 2]) -> Vec<f32> {
    /// The light, in parts of the picture's mean, below which pixels count alike.
    const DARK: f32 = 0.1;
    let pixels = own.pixels();
    let light = |i: usize| -> f32 {
        let channel = |c: usize| 0.5 * (filtered[0][c][i] + filtered[1][c][i]) * own.modulation[c][i];
        (0..3).map(channel).sum()
    };
    let lights: Vec<f32> = (0..pixels).map(light).collect();
    let mean = lights.iter().map(|light| f64::from(*light)).sum::<f64>() / pixels as f64;
    let dark = (DARK * mean as f32).powi(2);
    let weight = |i: usize| {
        let square = sum(&own.modulation, i).powi(2);
        own.tells_noise(i) * square / (lights[i] * lights[i] + dark).max(f32::MIN_POSITIVE)
    };
    (0..pixels).map(weight).collect()
}

/// The estimated squared error around each pixel of the mean of filtered halves, in parts of the noise of the mean that was
/// filtered: what differs from the other half beyond its noise.
///
/// The noise is that of single pixels, so that bright pixels lend none to those around. The first estimate takes halves as
/// correlated, to be on the safe side; the second does not, and is in parts of the noise of independent halves.
fn relative_errors(mean: &Signal, weights: &[f32], filtered: &[Color; 2], size: [usize; 2]) -> (Vec<f32>, Vec<f32>) {
    /// Pixels around a pixel, on each side, whose errors are averaged.
    const RADIUS: usize = 6;
    const MOST: f32 = 1e4;
    /// Where filtered light differs from the mean by less than the noise that is taken, the noise is lower, and the error unknown.
    const UNKNOWN: f32 = 3.0;
    let (mut errors, mut noise) = (vec![0.0; weights.len()], vec![0.0; weights.len()]);
    let pair = |halves: &[Color; 2], c: usize, i: usize| [halves[0][c][i], halves[1][c][i]];
    for (i, weight) in weights.iter().enumerate() {
        for c in 0..3 {
            let [a, b] = pair(filtered, c, i);
            let [own_a, own_b] = pair(&mean.halves, c, i);
            let (to_a, to_b) = (a - own_b, b - own_a);
            let square = 0.5 * (own_a - own_b) * (own_a - own_b);
            let error = 0.5 * (to_a * to_a + to_b * to_b) - OF_HALF * square - 0.25 * (a - b) * (a - b);
            errors[i] += weight * error + LEAST_ERROR;
            noise[i] += weight * OF_MEAN * square;
        }
    }
    let (mut errors, noise) = (blur::mean(&errors, size, RADIUS), blur::mean(&noise, size, RADIUS));
    let mut told = errors.clone();
    for ((error, told), noise) in errors.iter_mut().zip(&mut told).zip(noise) {
        let parts = *error / noise.max(f32::MIN_POSITIVE);
        *error = if parts < 0.0 {
            (-UNKNOWN * parts).min(UNKNOWN)
        } else {
            parts.min(MOST)
        };
        *told = (2.0 * (parts * OF_MEAN - (1.0 - OF_HALF))).clamp(-MOST, MOST);
    }
    (errors, told)
}

/// The squares by which the mean over frames differs from the own frame beyond the noise of both: light of other frames that does
/// not belong there.
fn ghosts(own: &Frame, mean: &Signal, noise: &[f32]) -> Vec<f32> {
    const RADIUS: usize = 3;
    /// The part of the noise by which the estimate errs.
    const CHANCE: f32 = 0.3;
    let square = |i: usize| -> f32 {
        let channel = |c: usize| {
            let [a, b] = [0, 1].map(|half| mean.halves[half][c][i] - own.signal.halves[half][c][i]);
            0.25 * (a + b) * (a + b)
        };
        (0..3).map(channel).sum()
    };
    let squares: Vec<f32> = (0..own.pixels()).map(square).collect();
    let mut ghosts = blur::mean(&squares, own.size, RADIUS);
    for (i, ghost) in ghosts.iter_mut().enumerate() {
        let of_own = 0.5 * sum(&own.signal.variance, i);
        *ghost = (*ghost - (of_own - noise[i]).max(0.0) - CHANCE * of_own).max(0.0);
    }
    ghosts
}

/// The noise that is left in the mean of filtered halves, squared, by their difference.
fn noise_left(filtered: &[Color; 2], size: [usize; 2]) -> Vec<f32> {
    const RADIUS: usize = 3;
    let pixel = |i: usize| -> f32 {
        let difference = |c: usize| filtered[0][c][i] - filtered[1][c][i];
        (0..3).map(|c| 0.25 * difference(c) * difference(c)).sum()
    };
    let squares = parallel::table(size[0] * size[1], pixel);
    blur::mean(&squares, size, RADIUS)
}
