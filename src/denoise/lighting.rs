//! The light of another frame brought to that of the own one, where something moves.
//!
//! A surface that turns, a lamp that dims and a shadow that comes near change the light of a surface slowly over the picture. Its
//! noise is fine. So the light is multiplied by the quotient of the means of both frames around each pixel, where these differ by
//! more than chance explains; what still differs then is left out.

use super::{
    albedo::scale,
    blur,
    choose::{LEAST_ERROR, error_weights},
    frame::Frame,
    signal::Signal,
};

/// Pixels around a pixel, on each side, whose light is compared.
const RADIUS: usize = 6;
const COUNT: f32 = ((2 * RADIUS + 1) * (2 * RADIUS + 1)) as f32;

/// For each pixel, the light of another frame in parts of its own albedo, or in parts of the own frame's: the nearer one. Where a
/// texture is noisy the first has less noise, at the edges of objects the second.
pub(super) fn nearer(own: &Frame, mut plain: Signal, scaled: &Signal) -> Signal {
    let apart = |signal: &Signal, i: usize| -> f32 {
        let difference = |c: usize| {
            let halves = [&own.signal, signal].map(|signal| signal.halves[0][c][i] + signal.halves[1][c][i]);
            halves[0] - halves[1]
        };
        (0..3).map(|c| difference(c) * difference(c)).sum()
    };
    for i in 0..own.pixels() {
        if apart(scaled, i) < apart(&plain, i) {
            for c in 0..3 {
                for (to, from) in plain.halves.iter_mut().zip(&scaled.halves) {
                    to[c][i] = from[c][i];
                }
                plain.variance[c][i] = scaled.variance[c][i];
            }
        }
    }
    plain
}

/// Brings the light of another frame to that of the own one, by the first signal, which is compared, and the second in
/// the same way. Returns the parts to which pixels are found, without those around which the light differs pixel by
/// pixel by more than chance explains.
pub(super) fn follow(own: &Frame, [other, beside]: [&mut Signal; 2], found: &[f32]) -> Vec<f32> {
    /// Squared differences of means in parts of their variance, from which on light is changed, and at
    /// which it is as much as they differ.
    const FROM: f32 = 2.0;
    const TO: f32 = 6.0;
    /// The least variance, in parts of the square of the light.
    const LEAST: f32 = 0.02 * 0.02;
    /// The largest factor.
    const MOST: f32 = 2.0;
    let pixels = own.pixels();
    let mean = |signal: &Signal, c: usize, i: usize| 0.5 * (signal.halves[0][c][i] + signal.halves[1][c][i]);
    let smooth = |value: &dyn Fn(usize) -> f32| -> Vec<f32> {
        let plane: Vec<f32> = (0..pixels).map(value).collect();
        blur::mean(&plane, own.size, RADIUS)
    };
    let means = [0, 1, 2].map(|c| {
        [
            smooth(&|i| found[i] * mean(&own.signal, c, i)),
            smooth(&|i| found[i] * mean(other, c, i)),
        ]
    });
    let variance = smooth(&|i| {
        let channels =
            (0..3).map(|c| own.signal.variance[c][i] + other.variance[c][i] + LEAST * mean(other, c, i).powi(2));
        found[i] * found[i] * 0.5 * channels.sum::<f32>()
    });
    let change = |i: usize| {
        let shift: f32 = means.iter().map(|[own, other]| (own[i] - other[i]).powi(2)).sum();
        let parts = COUNT * shift / variance[i].max(f32::MIN_POSITIVE);
        ((parts - FROM) / (TO - FROM)).clamp(0.0, 1.0)
    };
    let changes: Vec<f32> = (0..pixels).map(change).collect();
    for (c, [own, of_other]) in means.iter().enumerate() {
        let factor = |i: usize| {
            let quotient = own[i] / of_other[i].max(f32::MIN_POSITIVE);
            1.0 + changes[i] * (quotient.clamp(1.0 / MOST, MOST) - 1.0)
        };
        let factors: Vec<f32> = (0..pixels).map(factor).collect();
        scale(other, c, &factors);
        scale(beside, c, &factors);
    }
    explained(own, other, found)
}

/// The parts to which pixels are found, times the part of the difference of the light around them that noise explains.
fn explained(own: &Frame, other: &Signal, found: &[f32]) -> Vec<f32> {
    /// The variance of the mean of the halves, in parts of their squared difference.
    const NOISE: f32 = 0.4;
    let pixels = own.pixels();
    let weights = error_weights(own, &own.signal.halves);
    let (mut apart, mut noise) = (vec![0.0; pixels], vec![0.0; pixels]);
    for c in 0..3 {
        let halves = [&own.signal.halves, &other.halves].map(|halves| [&halves[0][c], &halves[1][c]]);
        for i in 0..pixels {
            let difference = 0.5 * (halves[0][0][i] + halves[0][1][i] - halves[1][0][i] - halves[1][1][i]);
            let square: f32 = halves.iter().map(|half| (half[0][i] - half[1][i]).powi(2)).sum();
            let square_found = found[i] * found[i];
            apart[i] += square_found * (weights[i] * difference * difference + LEAST_ERROR);
            noise[i] += square_found * (weights[i] * NOISE * square + LEAST_ERROR);
        }
    }
    let [apart, noise] = [apart, noise].map(|plane| blur::mean(&plane, own.size, RADIUS));
    let part = |i: usize| found[i] * (noise[i] / apart[i].max(f32::MIN_POSITIVE)).min(1.0);
    (0..pixels).map(part).collect()
}
