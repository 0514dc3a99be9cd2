//! Transcendental functions with the same bits on every machine: the system's library never
//! answers; polynomials or `libm` do.
//!
//! Polynomials go through the Chebyshev nodes of their interval, and have no fused multiply-add. Tests measure their largest
//! errors over all arguments, or over many pairs of them.

use std::{
    f32::consts::{FRAC_PI_2, PI},
    f64,
};

/// The sine; see [`sin_cos`].
#[inline]
pub fn sin(x: f32) -> f32 {
    sin_cos(x).0
}

/// The cosine; see [`sin_cos`].
#[inline]
pub fn cos(x: f32) -> f32 {
    sin_cos(x).1
}

/// Sine and cosine, off by less than 1.3e-7 up to 1000 radians, beyond which `libm` answers.
#[inline]
pub fn sin_cos(x: f32) -> (f32, f32) {
    if x.is_nan() || x.abs() > MAX_QUADRANT_ANGLE {
        return libm::sincosf(x);
    }
    sin_cos_in_range(x)
}

/// The same of an angle of at most 1000 radians either way, without branches, for vectors.
#[inline(always)]
pub fn sin_cos_in_range(x: f32) -> (f32, f32) {
    // The right angle in three parts: products of the first two with small whole numbers are exact.
    const PARTS: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
    let quadrant = nearest_whole(x * std::f32::consts::FRAC_2_PI);
    let rest = ((x - quadrant * PARTS[0]) - quadrant * PARTS[1]) - quadrant * PARTS[2];
    let (sin, cos) = sin_cos_eighth(rest);
    let quadrant = quadrant as i32;
    let is_odd = quadrant & 1 != 0;
    let (sin, cos) = (if is_odd { cos } else { sin }, if is_odd { sin } else { cos });
    (
        if quadrant & 2 != 0 { -sin } else { sin },
        if (quadrant + 1) & 2 != 0 { -cos } else { cos },
    )
}

/// The nearest whole number, the even one of two, of a number of at most 2^22 either way. The library's function is a call on
/// processors that lack an instruction for it.
#[inline(always)]
fn nearest_whole(x: f32) -> f32 {
    const LARGE: f32 = 12_582_912.0; // 1.5 * 2^23: larger floats have no fraction
    (x + LARGE) - LARGE
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

/// Sine and cosine of parts of a whole turn, a number of at most 2^20 either way, off by less than 1e-15; without branches, for
/// vectors.
#[inline(always)]
pub fn sin_cos_turn(turn: f64) -> (f64, f64) {
    const LARGE: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52: the last bits are those of the whole number
    let shifted = 4.0 * turn + LARGE;
    let (quadrant, x) = (
        shifted.to_bits(),
        (4.0 * turn - (shifted - LARGE)) * f64::consts::FRAC_PI_2,
    );
    let z = x * x;
    let sin = 1.0 / 362_880.0 - z * (1.0 / 39_916_800.0 - z * (1.0 / 6_227_020_800.0 - z / 1_307_674_368_000.0));
    let sin = x - x * z * (1.0 / 6.0 - z * (1.0 / 120.0 - z * (1.0 / 5040.0 - z * sin)));
    let cos = 1.0 / 3_628_800.0 - z * (1.0 / 479_001_600.0 - z * (1.0 / 87_178_291_200.0 - z / 20_922_789_888_000.0));
    let cos = 1.0 - z * (0.5 - z * (1.0 / 24.0 - z * (1.0 / 720.0 - z * (1.0 / 40_320.0 - z * cos))));
    let is_odd = quadrant & 1 != 0;
    let (sin, cos) = (if is_odd { cos } else { sin }, if is_odd { sin } else { cos });
    (
        if quadrant & 2 != 0 { -sin } else { sin },
        if (quadrant + 1) & 2 != 0 { -cos } else { cos },
    )
}

pub fn tan(x: f32) -> f32 {
    libm::tanf(x)
}

/// The arc sine, off by less than 1.6e-7; NaN beyond 1.
#[inline(always)]
pub fn asin(x: f32) -> f32 {
    let (near, is_small) = nearest_arc(x);
    let angle = if is_small { near } else { FRAC_PI_2 - 2.0 * near };
    angle.copysign(x)
}

/// The arc cosine, off by less than 3e-7; NaN beyond 1.
#[inline(always)]
pub fn acos(x: f32) -> f32 {
    let (near, is_small) = nearest_arc(x);
    let signed = near.copysign(x);
    let from_end = 2.0 * near;
    match (is_small, x < 0.0) {
        (true, _) => FRAC_PI_2 - signed,
        (false, true) => PI - from_end,
        (false, false) => from_end,
    }
}

/// The arc sine of |x| up to 1 / 2, and true; beyond, half the arc cosine of |x|, and false: the arc sine of the root of half of
/// what is missing to 1.
#[inline(always)]
fn nearest_arc(x: f32) -> (f32, bool) {
    let x = x.abs();
    let is_small = x <= 0.5;
    let rest = 0.5 * (1.0 - x);
    let z = if is_small { x * x } else { rest };
    let s = if is_small { x } else { rest.sqrt() };
    let p = 0.017_149_238 + z * 0.033_690_847;
    let p = 0.044_599_4 + z * (0.031_100_663 + z * p);
    let p = 0.166_666_66 + z * (0.075_000_94 + z * p);
    (s + s * z * p, is_small)
}

/// The angle from the x axis to (x, y), from -pi to pi, off by less than 4e-7.
#[inline(always)]
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

/// The angle from the x axis to (x, y) in double precision, for a `y` of at least 0: from 0 to pi, off by less than 1e-15.
#[inline(always)]
pub fn angle_above(y: f64, x: f64) -> f64 {
    const TAN_SIXTEENTH: f64 = 0.414_213_562_373_095_05;
    let ax = x.abs();
    let is_steep = y > ax;
    let (less, more) = if is_steep { (ax, y) } else { (y, ax) };
    let is_far = less > more * TAN_SIXTEENTH;
    let (less, more) = if is_far {
        (less - more, less + more)
    } else {
        (less, more)
    };
    let t = less / more;
    let z = t * t;
    let p = -0.043_480_522_157_162_46 + z * 0.021_135_373_157_693_246;
    let p = -0.066_402_339_304_294_08 + z * (0.056_883_492_268_090_106 + z * p);
    let p = -0.090_907_730_748_088_14 + z * (0.076_899_534_963_068_57 + z * p);
    let p = -0.142_857_141_809_764_67 + z * (0.111_111_061_804_559_46 + z * p);
    let p = -0.333_333_333_333_284_4 + z * (0.199_999_999_988_551_1 + z * p);
    let angle = t + t * z * p;
    let angle = if is_far { f64::consts::FRAC_PI_4 + angle } else { angle };
    let angle = if is_steep {
        f64::consts::FRAC_PI_2 - angle
    } else {
        angle
    };
    if x < 0.0 { f64::consts::PI - angle } else { angle }
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

    fn asin_acos_error(step: usize) -> [f64; 2] {
        let error = |x: f32| {
            let (sine, cosine) = (libm::asin(x.into()), libm::acos(x.into()));
            [(f64::from(asin(x)) - sine).abs(), (f64::from(acos(x)) - cosine).abs()]
        };
        floats(1.0, step)
            .flat_map(|x| [error(x), error(-x)])
            .fold([0.0; 2], |most, e| [most[0].max(e[0]), most[1].max(e[1])])
    }

    #[test]
    fn errors_are_as_small_as_stated() {
        let (sin_cos, atan) = (sin_cos_error(2039), atan_error(2039));
        assert!(sin_cos < 1.3e-7 && atan < 1.1e-7, "{sin_cos:e} {atan:e}");
        let [asin, acos] = asin_acos_error(2039);
        assert!(asin < 1.6e-7 && acos < 3e-7, "{asin:e} {acos:e}");
    }

    #[test]
    fn turns_and_the_angles_of_their_points_agree_with_the_library_in_double_precision() {
        for i in -4000..=4000_i32 {
            let turn = f64::from(i) / 4000.0 * 1.25;
            let (exact_sin, exact_cos) = libm::sincos(turn * f64::consts::TAU);
            let (sin, cos) = sin_cos_turn(turn);
            assert!((sin - exact_sin).abs().max((cos - exact_cos).abs()) < 2e-15, "{turn}");
            let length = libm::exp2(f64::from(i % 97));
            let (y, x) = (sin.abs() * length, cos * length);
            assert!((angle_above(y, x) - libm::atan2(y, x)).abs() < 1e-15, "{turn}");
        }
        assert_eq!((sin_cos_turn(0.25), sin_cos_turn(1.0)), ((1.0, -0.0), (0.0, 1.0)));
        assert_eq!(angle_above(0.0, -1.0), f64::consts::PI);
        assert_eq!(angle_above(2.0, 2.0), f64::consts::FRAC_PI_4);
    }

    #[test]
    fn arcs_end_where_the_circle_does() {
        assert_eq!((asin(0.0), asin(1.0), asin(-1.0)), (0.0, FRAC_PI_2, -FRAC_PI_2));
        assert_eq!((acos(1.0), acos(0.0), acos(-1.0)), (0.0, FRAC_PI_2, PI));
        assert!(asin(1.1).is_nan() && acos(-1.1).is_nan() && acos(f32::NAN).is_nan());
    }

    #[test]
    #[ignore = "all floats take a minute"]
    fn errors_of_all_floats_are_as_small_as_stated() {
        let (sin_cos, atan) = (sin_cos_error(1), atan_error(1));
        assert!(sin_cos < 1.3e-7 && atan < 1.1e-7, "{sin_cos:e} {atan:e}");
        let [asin, acos] = asin_acos_error(1);
        assert!(asin < 1.6e-7 && acos < 3e-7, "{asin:e} {acos:e}");
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
