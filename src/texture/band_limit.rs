//! The contrast of a pattern that is left in its mean over a footprint.
//!
//! Features that are smaller than the footprint cannot be seen, and would be noise. They fade to the mean of the pattern.

/// The width of the footprint, in features, from which on nothing is left.
const UNSEEN: f32 = 4.0;

/// The part of a pattern's contrast that is left where a footprint of this width and length is averaged, in units of the size of
/// its features. `falloff` is the rate at which the pattern's mean over a line loses contrast with the square of its length, fitted
/// to means over many lines and rectangles. All of it is left at a point, and nothing where the footprint is NaN.
#[inline]
pub fn contrast([width, length]: [f32; 2], falloff: f32) -> f32 {
    let over_line = |length: f32| 1.0 / (1.0 + falloff * length * length);
    let part = width / UNSEEN;
    let left = (1.0 - part * part).max(0.0) * over_line(width) * over_line(length);
    left.max(0.0)
}
