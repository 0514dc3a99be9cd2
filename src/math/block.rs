//! Blocks: numbers of some rays or surfaces, one in each lane, on which loops run as vectors.

use super::{Rgb, Vec3};

/// The number of lanes of a block: what fills a vector of AVX-512, and two of AVX2. With 8 lanes pictures take 1 to 4 % longer with
/// AVX-512, and as long with AVX2.
pub const LANES: usize = 16;

/// A number of each lane.
pub type Each<T = f32> = [T; LANES];

/// Returns the vector of a lane.
#[inline(always)]
pub fn get([x, y, z]: &[Each; 3], lane: usize) -> Vec3 {
    Vec3::new(x[lane], y[lane], z[lane])
}

/// Sets the vector of a lane.
#[inline(always)]
pub fn set([x, y, z]: &mut [Each; 3], lane: usize, to: Vec3) {
    (x[lane], y[lane], z[lane]) = (to.x, to.y, to.z);
}

/// Returns the colour of a lane.
#[inline(always)]
pub fn get_rgb([r, g, b]: &[Each; 3], lane: usize) -> Rgb {
    Rgb::new(r[lane], g[lane], b[lane])
}

/// Sets the colour of a lane.
#[inline(always)]
pub fn set_rgb([r, g, b]: &mut [Each; 3], lane: usize, to: Rgb) {
    (r[lane], g[lane], b[lane]) = (to.r, to.g, to.b);
}
