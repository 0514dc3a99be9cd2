//! Transcendental functions with the same bits on every machine: the system's library never answers, `libm` does.

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
