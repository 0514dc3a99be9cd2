//! The brightness that pixels may be taken to have, whatever their own noise says.
//!
//! Spots of light, such as mirrored lamps and suns, are many times as bright as what is around them, and no feature of the first
//! surface tells where they end. Neither their light nor their noise is lent across such a step.

use super::signal::Color;
use crate::math::parallel;

/// Pixels on each side of a pixel that say how bright it may be taken to be.
const RADIUS: usize = 2;

/// The largest ratio of another pixel's brightness to the own at which it lends all its light.
const LENDS_LIGHT: f32 = 2.0;

/// The largest ratio of the own brightness to another pixel's at which all its darkness is taken in.
const TAKES_DARKNESS: f32 = 16.0;

/// The largest ratio of another pixel's brightness to the own at which it lends all its noise.
const LENDS_NOISE: f32 = 4.0;

/// The brightness of each pixel: the sum of the channels of the brighter half, or the median of those around if that is more.
pub(super) fn levels(halves: &[Color; 2], [width, height]: [usize; 2]) -> Vec<f32> {
    let sum = |half: usize, i: usize| (0..3).map(|c| halves[half][c][i]).sum::<f32>();
    let bright: Vec<f32> = (0..width * height).map(|i| sum(0, i).max(sum(1, i))).collect();
    let level = |i: usize| {
        let around = |at: usize, size: usize| at.saturating_sub(RADIUS)..(at + RADIUS + 1).min(size);
        let mut values = [0.0; (2 * RADIUS + 1) * (2 * RADIUS + 1)];
        let mut count = 0;
        for y in around(i / width, height) {
            for value in &bright[y * width..][around(i % width, width)] {
                values[count] = *value;
                count += 1;
            }
        }
        let (_, median, _) = values[..count].select_nth_unstable_by(count / 2, f32::total_cmp);
        median.max(bright[i])
    };
    parallel::table(width * height, level)
}

/// The part that counts of another pixel's light: less than 1 where one of the two is too bright for the other.
#[inline(always)]
pub(super) fn share(own: f32, other: f32) -> f32 {
    const TINY: f32 = 1e-30;
    let (lent, taken) = ((LENDS_LIGHT * own).max(TINY), (TAKES_DARKNESS * other).max(TINY));
    (lent / other.max(lent)) * (taken / own.max(taken))
}

/// The mean of the noise around each pixel by the weights of a 5 x 5 binomial: brighter pixels lend no more of theirs than a pixel
/// of `LENDS_NOISE` times the own brightness would have.
pub(super) fn noise_around(noise: &[f32], levels: &[f32], [width, height]: [usize; 2]) -> Vec<f32> {
    const TAPS: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];
    let pixel = |i: usize| -> f32 {
        let most = LENDS_NOISE * levels[i];
        let mut sum = 0.0;
        for (dy, down) in TAPS.iter().enumerate() {
            let y = (i / width + dy).saturating_sub(RADIUS).min(height - 1);
            for (dx, across) in TAPS.iter().enumerate() {
                let j = y * width + (i % width + dx).saturating_sub(RADIUS).min(width - 1);
                let part = if levels[j] > most { most / levels[j] } else { 1.0 };
                sum += down * across * part * part * noise[j];
            }
        }
        sum
    };
    parallel::table(noise.len(), pixel)
}
