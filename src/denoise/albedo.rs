//! The mean over time of the divisor of light.
//!
//! At the edges of textures and objects few samples tell the albedo of a pixel badly, and its noise is that of the light, too.
//! Where something moves, both are averaged along the motion with the same weights: the noise of the one cancels in the quotient,
//! which is filtered, and that of the other becomes less.

use super::{
    blur,
    choose::OF_MEAN,
    frame::{Frame, divide},
    signal::{Color, Signal},
};

/// The divisor of the light of another frame at the pixels of the own one, with an alpha of 1.
pub(super) struct Albedo {
    pub color: Color,
    /// The variance of the albedo, summed over the channels.
    pub variance: Vec<f32>,
    /// Whether each pixel lies between pixels of the other frame.
    pub is_between: Vec<bool>,
}

impl Albedo {
    /// That of a frame at its own pixels.
    pub fn of(frame: &Frame) -> Self {
        let mut color = frame.modulation.clone();
        for plane in &mut color {
            divide(plane, &frame.alpha);
        }
        Self {
            color,
            variance: frame.guides.albedo_variance.clone(),
            is_between: vec![false; frame.pixels()],
        }
    }
}

/// The mean of the own albedo and those of other frames.
pub(super) struct AlbedoMean {
    own: Albedo,
    sum: Color,
}

impl AlbedoMean {
    pub fn new(own: &Frame) -> Self {
        let own = Albedo::of(own);
        Self {
            sum: own.color.clone(),
            own,
        }
    }

    /// Brings the light of another frame to the own divisor, and its albedo as near to the own one as noise leaves in doubt.
    pub fn bring(&self, (signal, other): (&mut Signal, &mut Albedo), found: &[f32], size: [usize; 2]) {
        let explained = self.explained(other, found, size);
        for (c, color) in other.color.iter_mut().enumerate() {
            let own = &self.own.color[c];
            for ((value, own), part) in color.iter_mut().zip(own).zip(&explained) {
                *value = own + part * (*value - own);
            }
            let factor = |(own, value): (&f32, &f32)| if *own > 0.0 { value / own } else { 0.0 };
            scale(signal, c, &own.iter().zip(&*color).map(factor).collect::<Vec<f32>>());
        }
    }

    /// Adds the albedo of another frame.
    pub fn add(&mut self, other: &Albedo, weights: &[f32]) {
        for (sum, color) in self.sum.iter_mut().zip(&other.color) {
            for ((sum, weight), value) in sum.iter_mut().zip(weights).zip(color) {
                *sum += weight * value;
            }
        }
    }

    /// The part of the difference of albedos around each pixel that noise explains: between pixels another frame blurs sharp edges.
    fn explained(&self, other: &Albedo, found: &[f32], size: [usize; 2]) -> Vec<f32> {
        const RADIUS: usize = 2;
        /// The squared difference that counts as noise, in parts of the variance by halves. The second is that of pixels which lie
        /// between those of the other frame, where it may be blur.
        const NOISE: [f32; 2] = [12.0 * OF_MEAN, 5.0 * OF_MEAN];
        const TINY: f32 = 1e-12;
        let square = |i: usize| -> f32 { (0..3).map(|c| (self.own.color[c][i] - other.color[c][i]).powi(2)).sum() };
        let apart: Vec<f32> = (0..found.len()).map(|i| found[i] * square(i)).collect();
        let variance =
            |i: usize| found[i] * NOISE[usize::from(other.is_between[i])] * (self.own.variance[i] + other.variance[i]);
        let noise: Vec<f32> = (0..found.len()).map(variance).collect();
        let [apart, noise] = [apart, noise].map(|plane| blur::mean(&plane, size, RADIUS));
        let explained = |i: usize| ((noise[i] + TINY) / (apart[i] + TINY)).min(1.0);
        (0..found.len()).map(explained).collect()
    }

    /// Brings the mean of the light from the own divisor to the mean one, which it returns.
    pub fn finish(mut self, own: &Frame, total: &[f32], signal: &mut Signal) -> Color {
        for c in 0..3 {
            divide(&mut self.sum[c], total);
            let means = self.own.color[c].iter().zip(&self.sum[c]);
            let factors: Vec<f32> = means
                .map(|(own, mean)| if *mean > 0.0 { own / mean } else { 0.0 })
                .collect();
            scale(signal, c, &factors);
            self.sum[c]
                .iter_mut()
                .zip(&own.alpha)
                .for_each(|(mean, alpha)| *mean *= alpha);
        }
        self.sum
    }
}

/// Multiplies a channel of light.
pub(super) fn scale(signal: &mut Signal, c: usize, factors: &[f32]) {
    let Signal {
        halves,
        variance,
        light,
    } = signal;
    for color in halves.iter_mut().chain(light) {
        color[c].iter_mut().zip(factors).for_each(|(value, by)| *value *= by);
    }
    variance[c]
        .iter_mut()
        .zip(factors)
        .for_each(|(value, by)| *value *= by * by);
}
