//! Transcendental functions with the same bits on every machine: the system's library never
//! answers; polynomials or `libm` do.
//!
//! Polynomials go through the Chebyshev nodes of their interval, and have no fused multiply-add. Tests measure their largest
//! errors over all arguments, or over many pairs of them.

use std::f32::consts::{FRAC_PI_2, PI};

pub fn sin(x: f32) -> f32 {
    libm::sinf(x)
}

pub fn cos(x: f32) -> f32 {
    libm::cosf(x)
}

/// Sine and cosine, off by less than 1.3e-7 up to 1000 radians, beyond which `libm` answers.
#[inline]
pub fn sin_cos(x: f32) -> (f32, f32) {
    // The right angle in three parts: products of the first two with small whole numbers are exact.
    const PARTS: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
    if x.is_nan() || x.abs() > MAX_QUADRANT_ANGLE {
        return libm::sincosf(x);
    }
    let quadrant = (x * std::f32::consts::FRAC_2_PI).round_ties_even();
    let rest = ((x - quadrant * PARTS[0]) - quadrant * PARTS[1]) - quadrant * PARTS[2];
    let (sin, cos) = sin_cos_eighth(rest);
    match quadrant as i32 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// The largest angle that is brought into a quadrant by subtraction, in radians.
const MAX_QUADRANT_ANGLE: f32 = 1000.0;

/// Sine and cosine of an angle of at most pi / 4 either way, off by less than 1.2e-7.
///
/// Polynomials through the Chebyshev nodes of the square, for what is drawn for every path;
/// [`sin_cos`] takes five times as long.
#[inline(always)]
pub fn sin_cos_eighth(x: f32) -> (f32, f32) {
    let x2 = x * x;
    let sin = 1.0 + x2 * (-0.166_666_67 + x2 * (0.008_333_329 + x2 * (-0.000_198_392_02 + x2 * 2.717_345_8e-6)));
    let cos = 1.0 + x2 * (-0.5 + x2 * (0.041_666_616 + x2 * (-0.001_388_661_8 + x2 * 2.437_983_1e-5)));
    (x * sin, cos)
}

pub fn tan(x: f32) -> f32 {
    libm::tanf(x)
}

pub fn asin(x: f32) -> f32 {
    libm::asinf(x)
}

pub fn acos(x: f32) -> f32 {
    libm::acosf(x)
}

/// The angle from the x axis to (x, y), from -pi to pi, off by less than 4e-7.
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let is_steep = ay > ax;
    let (less, more) = if is_steep { (ax, ay) } else { (ay, ax) };
    let ratio = if less == more {
        // Also of two infinities; of two zeros the angle is that of the axis.
        if less == 0.0 { 0.0 } else { 1.0 }
    } else {
        less / more
    };
    let angle = atan_up_to_one(ratio);
    let angle = if is_steep { FRAC_PI_2 - angle } else { angle };
    let angle = if x.is_sign_negative() { PI - angle } else { angle };
    angle.copysign(y)
}

/// The arc tangent of a number from 0 to 1, off by less than 1.1e-7.
#[inline(always)]
fn atan_up_to_one(x: f32) -> f32 {
    let z = x * x;
    let p = -0.015_731_249 + z * 0.002_766_283_5;
    let p = -0.074_568_55 + z * (0.042_137_623 + z * p);
    let p = -0.141_977_98 + z * (0.106_183_71 + z * p);
    let p = -0.333_330_36 + z * (0.199_918_72 + z * p);
    x * (1.0 + z * p)
}

pub fn exp(x: f32) -> f32 {
    libm::expf(x)
}

pub fn ln(x: f32) -> f32 {
    libm::logf(x)
}

/// The logarithm to base 2.
pub fn log2(x: f32) -> f32 {
    libm::log2f(x)
}

/// `x` to the power `y`. Small whole powers, the common Phong exponents, are products.
pub fn pow(x: f32, y: f32) -> f32 {
    if y == 4.0 {
        let x2 = x * x;
        return x2 * x2;
    }
    libm::powf(x, y)
}

/// Degrees of files to the radians of everything else.
pub fn radians(degrees: f32) -> f32 {
    degrees * (PI / 180.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_eighth_of_a_turn_agrees_with_the_library() {
        for i in -1000..=1000_i16 {
            let x = f32::from(i) / 1000.0 * (PI / 4.0);
            let (sin, cos) = sin_cos_eighth(x);
            let (exact_sin, exact_cos) = libm::sincos(x.into());
            assert!((f64::from(sin) - exact_sin).abs() < 1.2e-7, "{x}");
            assert!((f64::from(cos) - exact_cos).abs() < 1.2e-7, "{x}");
        }
    }

    /// The floats from 0 to `end`, every `step`th.
    fn floats(end: f32, step: usize) -> impl Iterator<Item = f32> {
        (0..=end.to_bits()).step_by(step).map(f32::from_bits)
    }

    fn sin_cos_error(step: usize) -> f64 {
        let error = |x: f32| {
            let ((sin, cos), (exact_sin, exact_cos)) = (sin_cos(x), libm::sincos(x.into()));
            (f64::from(sin) - exact_sin)
                .abs()
                .max((f64::from(cos) - exact_cos).abs())
        };
        floats(MAX_QUADRANT_ANGLE, step).fold(0.0, |most, x| error(x).max(error(-x)).max(most))
    }

    fn atan_error(step: usize) -> f64 {
        let error = |x: f32| (f64::from(atan_up_to_one(x)) - libm::atan(x.into())).abs();
        floats(1.0, step).fold(0.0, |most, x| error(x).max(most))
    }

    #[test]
    fn errors_are_as_small_as_stated() {
        let (sin_cos, atan) = (sin_cos_error(2039), atan_error(2039));
        assert!(sin_cos < 1.3e-7 && atan < 1.1e-7, "{sin_cos:e} {atan:e}");
    }

    #[test]
    #[ignore = "all floats take a minute"]
    fn errors_of_all_floats_are_as_small_as_stated() {
        let (sin_cos, atan) = (sin_cos_error(1), atan_error(1));
        assert!(sin_cos < 1.3e-7 && atan < 1.1e-7, "{sin_cos:e} {atan:e}");
    }

    #[test]
    fn the_angle_of_a_point_agrees_with_the_library_in_all_directions() {
        let mut most: f64 = 0.0;
        for i in 0..200_000_u32 {
            let angle = f64::from(i) / 200_000.0 * std::f64::consts::TAU;
            let length = libm::exp2(f64::from(i % 97) - 48.0);
            let (x, y) = ((libm::cos(angle) * length) as f32, (libm::sin(angle) * length) as f32);
            let error = f64::from(atan2(y, x)) - libm::atan2(y.into(), x.into());
            most = most.max(error.abs());
        }
        assert!(most < 4e-7, "{most:e}");
    }

    #[test]
    fn angles_of_the_axes_of_nothing_and_of_the_infinite_are_those_of_the_library() {
        let values = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MIN_POSITIVE,
        ];
        for (y, x) in values.into_iter().flat_map(|y| values.map(|x| (y, x))) {
            let (found, exact) = (atan2(y, x), libm::atan2f(y, x));
            assert!(
                (found - exact).abs() < 4e-7 && found.is_sign_negative() == exact.is_sign_negative(),
                "{y} {x}: {found}"
            );
        }
        assert!(atan2(f32::NAN, 1.0).is_nan() && atan2(1.0, f32::NAN).is_nan());
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        assert!(sin_cos(f32::INFINITY).0.is_nan() && sin_cos(f32::NAN).1.is_nan());
        assert_eq!(sin_cos(1e6), libm::sincosf(1e6));
    }
}
