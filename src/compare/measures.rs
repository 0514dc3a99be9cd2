//! The measures of a pair of pictures.

use serde::Serialize;

use super::{CompareError, Picture, flip};
use crate::math::Rgb;

/// How far a test is from its reference. All are 0 for equal pictures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measures {
    /// The mean over pixels of FLIP, the difference that a viewer sees when the pictures alternate, from 0 to 1: HDR-FLIP for
    /// pictures of light, LDR-FLIP for display values. Of data it is [`pixels`](Self::pixels).
    pub flip: f64,
    /// The root of the mean squared difference of a number.
    pub rmse: f64,
    /// The mean over pixels and channels of the squared difference over the squared reference plus 0.01, which weighs dark and
    /// bright parts alike. Source: Rousselle et al., "Adaptive Sampling and Reconstruction using Greedy Error Minimization",
    /// SIGGRAPH Asia 2011.
    pub relmse: f64,
    /// The share of pixels of which a number (alpha included) is farther away than the limit. For ids the limit is 0.
    pub pixels: f64,
    /// The largest difference of a number, alpha included.
    pub largest: f64,
    /// The root of the mean squared difference of alpha.
    pub alpha_rmse: f64,
}

/// A test beside its reference.
#[derive(Clone, Debug)]
pub struct Comparison {
    pub measures: Measures,
    /// The mean red, green and blue of the reference and of the test.
    pub means: [[f64; 3]; 2],
    /// Numbers of the reference and of the test that are NaN or infinite.
    pub not_finite: [u64; 2],
    /// Columns and rows.
    pub size: [u32; 2],
    /// FLIP of each pixel, row by row from the top.
    pub flip: Vec<f32>,
}

impl Comparison {
    /// Compares two pictures of one size and one window. A difference of `limit` or less is none in [`Measures::pixels`].
    pub fn new(reference: &Picture, test: &Picture, limit: f32) -> Result<Self, CompareError> {
        let [a, b] = [reference.window, test.window];
        if a.display != b.display {
            return Err(CompareError::Size {
                reference: a.display,
                test: b.display,
            });
        }
        if (a.first, reference.size) != (b.first, test.size) {
            return Err(CompareError::Window {
                reference: (reference.size, a.first),
                test: (test.size, b.first),
            });
        }
        if reference.is_light != test.is_light {
            return Err(CompareError::Range);
        }
        let limit = data_limit(reference, test, limit)?;
        let flip = match (&reference.data, reference.is_light) {
            (Some(_), _) => differing(reference, test, limit),
            (None, true) => flip::of_light(reference, test),
            (None, false) => flip::of_display_values(reference, test),
        };
        let mut sums = Sums::default();
        for (i, (a, b)) in reference.pixels.iter().zip(&test.pixels).enumerate() {
            sums.add(*a, *b, reference.alpha(i) - test.alpha(i), limit);
        }
        let pixels = reference.pixels.len() as f64;
        Ok(Self {
            measures: Measures {
                flip: flip.iter().map(|v| f64::from(*v)).sum::<f64>() / pixels,
                rmse: (sums.squares / (3.0 * pixels)).sqrt(),
                relmse: sums.relative / (3.0 * pixels),
                pixels: sums.beyond as f64 / pixels,
                largest: f64::from(sums.largest),
                alpha_rmse: (sums.alpha / pixels).sqrt(),
            },
            means: [mean(reference), mean(test)],
            not_finite: [reference.not_finite, test.not_finite],
            size: reference.size,
            flip,
        })
    }
}

/// The limit of two pictures: 0 for ids, of which no two are near.
fn data_limit(reference: &Picture, test: &Picture, limit: f32) -> Result<f32, CompareError> {
    match (&reference.data, &test.data) {
        (None, None) => Ok(limit),
        (Some(a), Some(b)) if a.may_be(b) => Ok(if a.are_ids() || b.are_ids() { 0.0 } else { limit }),
        (Some(a), Some(b)) => Err(CompareError::Data {
            reference: a.to_string(),
            test: b.to_string(),
        }),
        _ => Err(CompareError::DataRange),
    }
}

/// 1 for each pixel of data that differs, else 0: no display shows data.
fn differing(reference: &Picture, test: &Picture, limit: f32) -> Vec<f32> {
    let pairs = reference.pixels.iter().zip(&test.pixels);
    let differs = |(a, b): (&Rgb, &Rgb)| (*a - *b).to_array().iter().any(|v| v.abs() > limit);
    pairs.map(|pair| f32::from(u8::from(differs(pair)))).collect()
}

#[derive(Default)]
struct Sums {
    squares: f64,
    relative: f64,
    alpha: f64,
    beyond: u64,
    largest: f32,
}

impl Sums {
    fn add(&mut self, reference: Rgb, test: Rgb, alpha: f32, limit: f32) {
        let mut largest = alpha.abs();
        for (a, b) in reference.to_array().into_iter().zip(test.to_array()) {
            largest = largest.max((b - a).abs());
            let (a, b) = (f64::from(a), f64::from(b));
            self.squares += (b - a) * (b - a);
            self.relative += (b - a) * (b - a) / (a * a + 0.01);
        }
        self.alpha += f64::from(alpha) * f64::from(alpha);
        self.beyond += u64::from(largest > limit);
        self.largest = self.largest.max(largest);
    }
}

fn mean(picture: &Picture) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for pixel in &picture.pixels {
        for (sum, v) in sum.iter_mut().zip(pixel.to_array()) {
            *sum += f64::from(v);
        }
    }
    sum.map(|v| v / picture.pixels.len() as f64)
}
