//! The sums of a pixel's samples, and its value and variance.

use crate::math::Rgb;

/// The weighted sum of the samples of one pixel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PixelSum {
    rgb: Rgb,
    alpha: f32,
    weight: f32,
    /// The unweighted sum: the fallback if the weights cancel.
    unsigned: Rgb,
    unsigned_alpha: f32,
    count: u32,
}

impl PixelSum {
    /// Adds a sample; `weight` is 1, or -1 where the filter is negative.
    #[inline]
    pub fn add(&mut self, l: Rgb, alpha: f32, weight: f32) {
        self.rgb += l * weight;
        self.alpha += alpha * weight;
        self.weight += weight;
        self.unsigned += l;
        self.unsigned_alpha += alpha;
        self.count += 1;
    }

    /// Adds the sum of later samples.
    pub fn append(&mut self, later: &Self) {
        self.rgb += later.rgb;
        self.alpha += later.alpha;
        self.weight += later.weight;
        self.unsigned += later.unsigned;
        self.unsigned_alpha += later.unsigned_alpha;
        self.count += later.count;
    }

    /// The pixel: premultiplied R, G, B and A.
    ///
    /// It is the weighted mean, or the plain mean if the sum of weights is less than a tenth of the samples, because the weighted
    /// mean would have unbounded noise then. Alpha is clamped to `[0, 1]`, because negative lobes of a filter overshoot at
    /// edges. Without samples it is 0.
    pub fn resolve(&self) -> [f32; 4] {
        let n = self.count.max(1) as f32;
        let (rgb, alpha) = if self.weight >= 0.1 * n {
            (self.rgb / self.weight, self.alpha / self.weight)
        } else {
            (self.unsigned / n, self.unsigned_alpha / n)
        };
        [rgb.r, rgb.g, rgb.b, alpha.clamp(0.0, 1.0)]
    }

    /// The pixel without its alpha.
    pub fn rgb(&self) -> [f32; 3] {
        let [r, g, b, _] = self.resolve();
        [r, g, b]
    }

    /// The number of samples.
    pub fn count(&self) -> u32 {
        self.count
    }
}

/// The sums of the first and the second half of a pixel's samples.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct HalfSums([PixelSum; 2]);

impl HalfSums {
    /// Makes all samples of `sum` the first half.
    pub fn of_first(sum: &PixelSum) -> Self {
        Self([*sum, PixelSum::default()])
    }

    /// Adds a sample of this half, 0 or 1; `weight` is 1, or -1 where the filter is negative.
    #[inline]
    pub fn add(&mut self, half: usize, l: Rgb, alpha: f32, weight: f32) {
        self.0[half].add(l, alpha, weight);
    }

    /// Adds the sums of later samples.
    pub fn append(&mut self, later: &Self) {
        for (own, later) in self.0.iter_mut().zip(&later.0) {
            own.append(later);
        }
    }

    /// The mean of this half of the samples without its alpha.
    pub fn mean(&self, half: usize) -> [f32; 3] {
        let [r, g, b, _] = self.resolve(half);
        [r, g, b]
    }

    /// The mean of this half of the samples with its alpha, of the other half if this one is empty, and 0 without samples.
    pub fn resolve(&self, half: usize) -> [f32; 4] {
        let is_there = |sum: &&PixelSum| sum.count() > 0;
        let own = Some(&self.0[half]).filter(is_there);
        own.or(Some(&self.0[1 - half]).filter(is_there))
            .map_or([0.0; 4], PixelSum::resolve)
    }

    /// The variance of the mean of both halves, if they are independent: `((a - b) / 2)^2`, and no larger than numbers can be; 0 if
    /// one has no samples.
    pub fn variance(&self) -> [f32; 3] {
        let (a, b) = (self.mean(0), self.mean(1));
        std::array::from_fn(|c| (0.5 * (a[c] - b[c])).powi(2).min(f32::MAX))
    }
}

/// The sums for the variance of a pixel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Moments {
    sum: [f64; 3],
    squares: [f64; 3],
    weight: f64,
    count: u64,
}

impl Moments {
    /// Adds a sample; `weight` is 1, or -1 where the filter is negative.
    pub fn add(&mut self, l: Rgb, weight: f32) {
        for (c, l) in l.to_array().into_iter().map(f64::from).enumerate() {
            self.sum[c] += l;
            self.squares[c] += l * l;
        }
        self.weight += f64::from(weight);
        self.count += 1;
    }

    /// Adds the sums of later samples.
    pub fn append(&mut self, later: &Self) {
        for c in 0..3 {
            self.sum[c] += later.sum[c];
            self.squares[c] += later.squares[c];
        }
        self.weight += later.weight;
        self.count += later.count;
    }

    /// The variance of `mean`, the mean of these samples, if they are independent; 0 for fewer than two.
    ///
    /// For samples `l` with weights `w` the weighted mean m has the variance `sum(w^2 (l - m)^2) / sum(w)^2`, to first order, times
    /// `n / (n - 1)`; all weights are 1 or -1. It is no larger than numbers can be.
    pub fn variance(&self, mean: [f32; 3]) -> [f32; 3] {
        if self.count < 2 {
            return [0.0; 3];
        }
        let n = self.count as f64;
        // If the weights cancel, the pixel is the plain mean.
        let weight = if self.weight >= 0.1 * n { self.weight } else { n };
        std::array::from_fn(|c| {
            let m = f64::from(mean[c]);
            let deviation = self.squares[c] - 2.0 * m * self.sum[c] + n * m * m;
            let variance = deviation.max(0.0) / (weight * weight) * n / (n - 1.0);
            variance.min(f64::from(f32::MAX)) as f32
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_stays_constant_under_signed_weights() {
        let mut sum = PixelSum::default();
        for weight in [1.0, 1.0, -1.0, 1.0] {
            sum.add(Rgb::gray(3.0), 1.0, weight);
        }
        assert_eq!(sum.resolve(), [3.0, 3.0, 3.0, 1.0]);
    }

    #[test]
    fn alpha_lies_between_0_and_1_whatever_the_lobes_of_the_filter() {
        // Four samples of a solid edge; the one with a negative weight lies on the other side of it.
        for (alphas, want) in [([1.0, 1.0, 1.0, 0.0], 1.0), ([0.0, 0.0, 0.0, 1.0], 0.0)] {
            let mut sum = PixelSum::default();
            for (alpha, weight) in alphas.into_iter().zip([1.0, 1.0, 1.0, -1.0]) {
                sum.add(Rgb::gray(1.0), alpha, weight);
            }
            assert_eq!(sum.resolve()[3], want);
        }
    }

    #[test]
    fn a_variance_is_that_of_the_mean_of_independent_samples() {
        let (mut sum, mut moments) = (PixelSum::default(), Moments::default());
        for l in [1.0, 2.0, 3.0, 6.0] {
            sum.add(Rgb::new(l, 5.0, 0.0), 1.0, 1.0);
            moments.add(Rgb::new(l, 5.0, 0.0), 1.0);
        }
        let [r, g, b, _] = sum.resolve();
        // The squared deviations from 3 sum to 14, over 4 * 3.
        assert_eq!(moments.variance([r, g, b]), [14.0 / 12.0, 0.0, 0.0]);
        assert_eq!(Moments::default().variance([0.0; 3]), [0.0; 3]);
    }

    #[test]
    fn the_variance_of_finite_light_is_finite() {
        let (mut sum, mut moments, mut halves) = (PixelSum::default(), Moments::default(), HalfSums::default());
        for (half, l) in [0.0, 1e38].into_iter().enumerate() {
            sum.add(Rgb::gray(l), 1.0, 1.0);
            moments.add(Rgb::gray(l), 1.0);
            halves.add(half, Rgb::gray(l), 1.0, 1.0);
        }
        let [r, g, b, _] = sum.resolve();
        assert_eq!(r, 0.5e38);
        assert_eq!(moments.variance([r, g, b]), [f32::MAX; 3]);
        assert_eq!(halves.variance(), [f32::MAX; 3]);
    }

    #[test]
    fn halves_tell_their_means_and_the_variance_of_both_together() {
        let mut halves = HalfSums::default();
        assert_eq!((halves.mean(0), halves.variance()), ([0.0; 3], [0.0; 3]));
        halves.add(0, Rgb::new(1.0, 2.0, 0.0), 0.25, 1.0);
        assert_eq!((halves.mean(1), halves.variance()), ([1.0, 2.0, 0.0], [0.0; 3]));
        halves.add(1, Rgb::new(5.0, 2.0, 0.0), 0.5, 1.0);
        halves.add(1, Rgb::new(9.0, 2.0, 0.0), 1.0, 1.0);
        assert_eq!(halves.mean(1), [7.0, 2.0, 0.0]);
        assert_eq!(halves.variance(), [9.0, 0.0, 0.0]);
        assert_eq!([0, 1].map(|half| halves.resolve(half)[3]), [0.25, 0.75]);
        // All of them may become the first half.
        let mut sum = PixelSum::default();
        sum.add(Rgb::gray(3.0), 1.0, 1.0);
        let mut halves = HalfSums::of_first(&sum);
        halves.add(1, Rgb::gray(5.0), 0.0, 1.0);
        assert_eq!((halves.mean(0), halves.mean(1)), ([3.0; 3], [5.0; 3]));
        assert_eq!([0, 1].map(|half| halves.resolve(half)[3]), [1.0, 0.0]);
    }

    #[test]
    fn weights_that_cancel_leave_the_plain_mean() {
        let mut sum = PixelSum::default();
        sum.add(Rgb::gray(1.0), 1.0, 1.0);
        sum.add(Rgb::gray(3.0), 1.0, -1.0);
        assert_eq!(sum.resolve(), [2.0, 2.0, 2.0, 1.0]);
    }
}
