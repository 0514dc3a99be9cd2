//! The layers of light of another frame that shows another scene: each counts as far as it agrees with that of the own frame.
//!
//! A lamp that dims, or that takes the place of another one, may change light groups and leave the beauty nearly as it is. A layer
//! has no halves that tell its noise, so the differences of the pixels of a window tell it: their mean, squared, is compared with
//! the variance of a mean of as many pixels (a paired t-test). As with the beauty (`lighting`), slow changes of the light are
//! followed, and what still differs is left out.

use super::{blur, signal::Color};
use crate::math::parallel;

/// The least variance, in parts of the square of the light.
const LEAST: f32 = 0.02 * 0.02;

/// Brings the layers of another frame to the light of the own ones. Returns the weights of the pixels of each layer, which
/// are those of the beauty or less.
pub(super) fn follow(own: &[Color], other: &mut [Color], (weights, size): (&[f32], [usize; 2])) -> Vec<Vec<f32>> {
    if own.is_empty() {
        return Vec::new();
    }
    let windows = [6, 2].map(|radius| Window::new(weights, size, radius));
    let layers = own.iter().zip(other);
    layers.map(|(own, other)| follow_layer(&windows, own, other)).collect()
}

/// Means by weights over squares of pixels.
struct Window<'a> {
    weights: &'a [f32],
    size: [usize; 2],
    radius: usize,
    /// The mean of the weights.
    covered: Vec<f32>,
    /// The number of pixels of weight 1 whose mean has the same variance.
    count: Vec<f32>,
}

/// What the layers of two frames tell of each other in a window.
struct Comparison {
    /// The means of both.
    means: [[Vec<f32>; 2]; 3],
    /// The mean of the squared differences, with the least variance.
    squares: Vec<f32>,
}

impl<'a> Window<'a> {
    fn new(weights: &'a [f32], size: [usize; 2], radius: usize) -> Self {
        let pixels = ((2 * radius + 1) * (2 * radius + 1)) as f32;
        let covered = blur::mean(weights, size, radius);
        let squares: Vec<f32> = weights.iter().map(|weight| weight * weight).collect();
        let squares = blur::mean(&squares, size, radius);
        let count = |(mean, square): (&f32, &f32)| pixels * mean * mean / square.max(f32::MIN_POSITIVE);
        Self {
            count: covered.iter().zip(&squares).map(count).collect(),
            weights,
            size,
            radius,
            covered,
        }
    }

    fn mean(&self, value: impl Fn(usize) -> f32 + Send + Sync) -> Vec<f32> {
        let weighted = parallel::table(self.weights.len(), |i| self.weights[i] * value(i));
        let mut mean = blur::mean(&weighted, self.size, self.radius);
        for (mean, covered) in mean.iter_mut().zip(&self.covered) {
            *mean /= covered.max(f32::MIN_POSITIVE);
        }
        mean
    }

    fn compare(&self, own: &Color, other: &Color) -> Comparison {
        let square = |i: usize| -> f32 {
            let channel = |c: usize| {
                let (own, other) = (own[c][i], other[c][i]);
                (own - other) * (own - other) + 0.5 * LEAST * (own * own + other * other)
            };
            (0..3).map(channel).sum()
        };
        Comparison {
            means: [0, 1, 2].map(|c| [self.mean(|i| own[c][i]), self.mean(|i| other[c][i])]),
            squares: self.mean(square),
        }
    }

    /// The squared difference of the means, that of the other frame times factors, in parts of the variance of the difference.
    fn shift(&self, compared: &Comparison, i: usize, factors: [f32; 3]) -> f32 {
        let square = |factors: [f32; 3]| -> f32 {
            let means = compared.means.iter().zip(factors);
            means.map(|([own, other], by)| (own[i] - by * other[i]).powi(2)).sum()
        };
        let variance = compared.squares[i] - square([1.0; 3]);
        self.count[i] * square(factors) / variance.max(f32::MIN_POSITIVE)
    }
}

/// Brings a layer of another frame to the light of the own one, compares both, and returns the weights of its pixels.
fn follow_layer([wide, near]: &[Window<'_>; 2], own: &Color, other: &mut Color) -> Vec<f32> {
    /// The shifts from which on light is changed, and at which it is changed as much as it differs.
    const CHANGE: [f32; 2] = [2.0, 6.0];
    /// The shifts at which weights start to fall, and are 0.
    const FALL: [f32; 2] = [4.0, 10.0];
    /// The largest factor.
    const MOST: f32 = 2.0;
    let part = |shift: f32, [from, to]: [f32; 2]| ((shift - from) / (to - from)).clamp(0.0, 1.0);
    let pixels = wide.weights.len();
    // Lamps that are off have no noise, and no light that another frame could tell.
    if is_black(own) != is_black(other) {
        return vec![0.0; pixels];
    }
    let compared = wide.compare(own, other);
    let factors = |i: usize| {
        let change = part(wide.shift(&compared, i, [1.0; 3]), CHANGE);
        compared.means.each_ref().map(|[own, other]| {
            let quotient = own[i] / other[i].max(f32::MIN_POSITIVE);
            1.0 + change * (quotient.clamp(1.0 / MOST, MOST) - 1.0)
        })
    };
    let factors: Vec<[f32; 3]> = parallel::table(pixels, factors);
    for (c, plane) in other.iter_mut().enumerate() {
        plane.iter_mut().zip(&factors).for_each(|(value, by)| *value *= by[c]);
    }
    let followed = near.compare(own, other);
    parallel::table(pixels, |i| {
        let shifts = [wide.shift(&compared, i, factors[i]), near.shift(&followed, i, [1.0; 3])];
        let alike = shifts.map(|shift| 1.0 - part(shift, FALL));
        wide.weights[i] * alike[0] * alike[1]
    })
}

fn is_black(color: &Color) -> bool {
    color.iter().all(|plane| plane.iter().all(|value| *value == 0.0))
}
