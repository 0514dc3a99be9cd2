//! The transfer function of sRGB: scene-linear light to display values and back.
//!
//! Source: IEC 61966-2-1:1999, the piecewise curve with its published constants.

use std::sync::LazyLock;

use crate::math::exponential;

/// The display value of linear light `x`; 0 to 0 and 1 to 1. Not clamped.
pub fn encode(x: f32) -> f32 {
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * exponential::pow(x, 1.0 / 2.4) - 0.055
    }
}

/// The linear light of the display value `v`: the inverse of [`encode`].
pub fn decode(v: f32) -> f32 {
    if v <= 0.040_45 {
        v / 12.92
    } else {
        exponential::pow((v + 0.055) / 1.055, 2.4)
    }
}

/// The linear light of an 8-bit display value.
pub fn decode8(code: u8) -> f32 {
    LINEAR[usize::from(code)]
}

/// The value of [`decode`] for every 16-bit display value.
pub fn decoded16() -> &'static [f32] {
    &LINEAR_16
}

/// `encode(x)` clamped to `[0, 1]` and rounded to 16 bits, NaN as 0.
pub fn encode16(x: f32) -> u16 {
    (encode(x.clamp(0.0, 1.0)) * 65535.0).round() as u16
}

/// The value of [`decode8`] for every code, for loops that look up many.
pub fn decoded() -> &'static [f32; 256] {
    &LINEAR
}

/// `encode(x)` clamped to `[0, 1]` and rounded to 8 bits, NaN as 0.
///
/// Looks up what the formula gives instead of evaluating it.
pub fn encode8(x: f32) -> u8 {
    let table = &*CODES;
    if x >= 1.0 {
        return 255;
    }
    if x.is_nan() || x <= 0.0 {
        return 0;
    }
    let mut code = table.first[(x.to_bits() >> BUCKET_SHIFT) as usize];
    while code < 255 && x >= table.threshold[usize::from(code) + 1] {
        code += 1;
    }
    code
}

static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| decode(i as f32 / 255.0)));
static LINEAR_16: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..=u16::MAX).map(|v| decode(f32::from(v) / 65535.0)).collect());
static CODES: LazyLock<Codes> = LazyLock::new(Codes::new);

/// Floats of one bucket differ by less than 1 part in 128, so at most two codes share one.
const BUCKET_SHIFT: u32 = 16;

struct Codes {
    /// The code of the smallest float of each bucket of `[0, 1)`.
    first: Vec<u8>,
    /// The smallest float that has at least this code.
    threshold: [f32; 256],
}

impl Codes {
    fn new() -> Self {
        let code = |bits: u32| (encode(f32::from_bits(bits)) * 255.0).round() as u8;
        let one = 1.0_f32.to_bits();
        let threshold = std::array::from_fn(|k| {
            // The bits of floats that are not negative rise with their value.
            let (mut low, mut high) = (0, one);
            while low < high {
                let middle = (low + high) / 2;
                if usize::from(code(middle)) >= k {
                    high = middle;
                } else {
                    low = middle + 1;
                }
            }
            f32::from_bits(low)
        });
        let first = (0..=one >> BUCKET_SHIFT).map(|b| code(b << BUCKET_SHIFT)).collect();
        Self { first, threshold }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_survives_decoding_and_encoding() {
        for code in 0..=255 {
            assert_eq!(encode8(decode8(code)), code);
        }
        for code in 0..=u16::MAX {
            assert_eq!(encode16(decoded16()[usize::from(code)]), code);
        }
        assert_eq!([f32::NAN, -1.0, 2.0].map(encode16), [0, 0, u16::MAX]);
    }

    #[test]
    fn encode8_equals_the_formula() {
        for bits in (0..=1.0_f32.to_bits()).step_by(1021) {
            let x = f32::from_bits(bits);
            assert_eq!(encode8(x), (encode(x) * 255.0).round() as u8, "{x}");
        }
        for code in 1..=255 {
            for x in [CODES.threshold[code].next_down(), CODES.threshold[code]] {
                assert_eq!(encode8(x), (encode(x) * 255.0).round() as u8, "{x}");
            }
        }
    }

    #[test]
    fn what_lies_outside_is_clamped_and_nan_is_black() {
        for (x, code) in [(f32::NAN, 0), (-1.0, 0), (-0.0, 0), (7.0, 255), (f32::INFINITY, 255)] {
            assert_eq!(encode8(x), code);
        }
        assert_eq!(encode8(f32::NEG_INFINITY), 0);
    }

    #[test]
    fn the_curve_meets_published_values() {
        for (linear, display) in [(0.0, 0.0), (0.18, 0.461_356_13), (0.5, 0.735_356_9), (1.0, 1.0)] {
            assert!((encode(linear) - display).abs() < 1e-6, "{linear}");
            assert!((decode(display) - linear).abs() < 1e-6, "{display}");
        }
    }
}
