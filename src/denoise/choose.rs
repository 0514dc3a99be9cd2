//! The mixture of what the windows and the noisy mean say, by their estimated errors.

use rayon::prelude::*;

use super::{
    blur,
    denoised::Denoised,
    frame::Frame,
    nlm::Filtered,
    signal::{Color, Signal, black},
};

/// Mixes the means of two windows with `mean`, the noisy signal that they filtered.
pub(super) fn choose(own: &Frame, mean: &Signal, windows: &[Filtered; 2]) -> Denoised {
    let noise: Vec<f32> = (0..own.pixels()).map(|i| 0.5 * sum(&mean.variance, i)).collect();
    let errors = [0, 1].map(|w| relative_errors(mean, &noise, &windows[w].halves, own.size));
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
        (0..noisy.len()).into_par_iter().map(pixel).collect()
    };
    let beauty: Color = std::array::from_fn(|c| {
        let [small, large] = [0, 1].map(|w| mean_of(&windows[w].halves, c));
        mix(&mean_of(&mean.halves, c), &small, &large, &own.modulation[c])
    });
    let layer = |layer: usize| -> Color {
        std::array::from_fn(|c| {
            let [small, large] = [0, 1].map(|w| &windows[w].light[layer][c]);
            mix(&mean.light[layer][c], small, large, &own.modulation[c])
        })
    };
    let mut denoised = Denoised {
        beauty,
        light: (0..mean.light.len()).map(layer).collect(),
        error: None,
        is_exact: exact(own),
    };
    scale_families(own, &mut denoised);
    let mut errors_left = black(own.pixels());
    let left = [0, 1].map(|w| noise_left(&windows[w].halves, own.size));
    for i in 0..own.pixels() {
        let (shares, rest) = (shares[i], 1.0 - shares[i][0] - shares[i][1]);
        let mut square = rest * rest * noise[i];
        for w in 0..2 {
            square += shares[w] * (errors[w][i].max(0.0) * noise[i]).max(left[w][i]);
        }
        let error = if denoised.is_exact[i] {
            0.0
        } else {
            (square / 3.0).sqrt()
        };
        for (plane, modulation) in errors_left.iter_mut().zip(&own.modulation) {
            plane[i] = error * modulation[i];
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
        scale_to_sum(&denoised.beauty, &mut denoised.light, family);
    }
}

fn scale_to_sum(beauty: &Color, light: &mut [Color], family: &[usize]) {
    for c in 0..3 {
        for (i, beauty) in beauty[c].iter().enumerate() {
            let sum: f32 = family.iter().map(|layer| light[*layer][c][i]).sum();
            for layer in family {
                let value = &mut light[*layer][c][i];
                if sum > 0.0 {
                    *value *= beauty / sum;
                } else {
                    *value += (beauty - sum) / family.len() as f32;
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
    const DOUBT: f32 = 0.2;
    const LEAST: f32 = 0.02;
    let errors = errors.map(|error| (error - DOUBT).max(0.0));
    let weights = errors.map(|error| 1.0 / (error + LEAST));
    let total = weights[0] + weights[1];
    let error = (weights[0] * errors[0] + weights[1] * errors[1]) / total;
    weights.map(|weight| weight / (total * (1.0 + error)))
}

fn sum(color: &Color, i: usize) -> f32 {
    color[0][i] + color[1][i] + color[2][i]
}

/// The estimated squared error around each pixel of the mean of filtered halves, in parts of the noise of the mean that was
/// filtered: what differs from the other half beyond its noise.
fn relative_errors(mean: &Signal, noise: &[f32], filtered: &[Color; 2], size: [usize; 2]) -> Vec<f32> {
    /// Pixels around a pixel, on each side, whose errors are averaged.
    const RADIUS: usize = 6;
    const MOST: f32 = 1e4;
    let pixel = |i: usize| {
        let mut square = 0.0;
        for (c, variance) in mean.variance.iter().enumerate() {
            let [a, b] = [filtered[0][c][i], filtered[1][c][i]];
            let (to_a, to_b) = (a - mean.halves[1][c][i], b - mean.halves[0][c][i]);
            square += 0.5 * (to_a * to_a + to_b * to_b) - variance[i] - 0.25 * (a - b) * (a - b);
        }
        if noise[i] > 0.0 {
            (square / noise[i]).clamp(-MOST, MOST)
        } else if square > 0.0 {
            MOST
        } else {
            0.0
        }
    };
    let errors: Vec<f32> = (0..noise.len()).into_par_iter().map(pixel).collect();
    blur::mean(&errors, size, RADIUS)
}

/// The noise that is left in the mean of filtered halves, squared, by their difference.
fn noise_left(filtered: &[Color; 2], size: [usize; 2]) -> Vec<f32> {
    const RADIUS: usize = 3;
    let pixel = |i: usize| -> f32 {
        let difference = |c: usize| filtered[0][c][i] - filtered[1][c][i];
        (0..3).map(|c| 0.25 * difference(c) * difference(c)).sum()
    };
    let squares: Vec<f32> = (0..size[0] * size[1]).into_par_iter().map(pixel).collect();
    blur::mean(&squares, size, RADIUS)
}
