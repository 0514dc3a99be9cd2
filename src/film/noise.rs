//! The display noise of pixels, by which adaptive sampling stops.
//!
//! A display curve is close to the square root up to white. An error `d` in a pixel of brightness `l` appears as `d / sqrt(l)`,
//! twice the change of the root. In the dark the curve of sRGB is linear, so `l` is at least [`DARKEST`]; above white the error
//! is relative, `d / l`.
//!
//! The error of the mean of `n` samples is estimated from halves: with `m` the mean of all samples and `a` that of the first half,
//! the expectation of `(m - a)^2` is `v(n / 2) - v(n)`, where `v(n)` is the variance of the mean of `n` samples, if both halves
//! have the same distribution. This holds for dependent samples, too. For independent ones it is `v(n)`; Owen-scrambled
//! sequences converge faster, by [`FALL`].
//!
//! The brightness is that of the darker half. A rare bright sample (a firefly) is in one half only, so it counts as an error and
//! does not make its own pixel bright.
//!
//! Sources: Dammertz, Hanika, Keller, Lensch, "A Hierarchical Automatic Stopping Condition for Monte Carlo Global Illumination",
//! WSCG 2010, for the halves and the square root; Cycles for the bound beyond white.

/// The brightness below which the curve of sRGB counts as linear: there `1 / (2 sqrt(l))` is its slope, 12.92.
pub const DARKEST: f64 = 0.0015;

/// The factor by which the variance of a pixel falls when its samples double: the median over the blocks of six scenes with 16 to
/// 256 samples (from 2.0 for light of rare paths to 2.7 on textured ground).
pub const FALL: f64 = 2.2;

/// The estimated squared display error of a pixel, from the mean of all samples and that of the first half: the mean over the
/// channels of the squared error relative to the brightness `l`, `e^2 / max(l, l^2, DARKEST)`.
/// `gain` is the factor of the exposure.
pub fn squared_error(mean: [f32; 3], half: [f32; 3], gain: f32) -> f64 {
    let shown = |v: [f32; 3]| v.map(|v| f64::from(v) * f64::from(gain));
    let (mean, half) = (shown(mean), shown(half));
    let brightness = |v: [f64; 3]| v.iter().sum::<f64>() / 3.0;
    let (both, first) = (brightness(mean), brightness(half));
    let l = first.min(2.0 * both - first).max(0.0);
    let change: f64 = mean.iter().zip(&half).map(|(m, h)| (m - h) * (m - h)).sum();
    change / 3.0 / (FALL - 1.0) / l.max(l * l).max(DARKEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error where the two halves are `l` minus and plus `d`.
    fn error(l: f32, d: f32, gain: f32) -> f64 {
        squared_error([l; 3], [l - d; 3], gain).sqrt()
    }

    fn assert_close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-3 * b, "{a} {b}");
    }

    #[test]
    fn an_error_counts_as_the_display_shows_it() {
        let error_of = |d: f64| d / (FALL - 1.0).sqrt();
        assert_close(error(0.25, 0.0001, 1.0), error_of(0.0002));
        assert_close(error(1.0, 0.0001, 1.0), error_of(0.0001));
        // Beyond white, and where the curve is straight.
        assert_close(error(4.0, 0.0004, 1.0), error_of(0.0001));
        assert_close(error(0.001, 0.0001, 1.0), error_of(0.0001 / DARKEST.sqrt()));
        // Two stops more make the same light four times as bright.
        assert_close(error(0.0625, 0.000_025, 4.0), error(0.25, 0.0001, 1.0));
        // One channel of three.
        let one = squared_error([0.25; 3], [0.25, 0.25, 0.2497], 1.0);
        assert_close(one.sqrt(), error_of(0.0003 / 3_f64.sqrt() / 0.5));
    }

    #[test]
    fn a_firefly_counts_the_same_in_either_half() {
        assert_close(error(2.0, 1.9, 1.0), error(2.0, -1.9, 1.0));
        let l = 0.1_f64;
        assert_close(error(2.0, 1.9, 1.0), 1.9 / (FALL - 1.0).sqrt() / l.sqrt());
    }

    #[test]
    fn pixels_without_noise_have_no_error() {
        for l in [0.0, 0.5, 100.0, -1.0] {
            assert_eq!(error(l, 0.0, 1.0), 0.0);
        }
    }
}
