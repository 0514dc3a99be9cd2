//! Transcendental functions with the same bits on every machine: the system's library never
//! answers, `libm` does.

use std::f32::consts::PI;

pub fn sin(x: f32) -> f32 {
    libm::sinf(x)
}

pub fn cos(x: f32) -> f32 {
    libm::cosf(x)
}

/// Sine and cosine.
pub fn sin_cos(x: f32) -> (f32, f32) {
    libm::sincosf(x)
}

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

pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
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
}
