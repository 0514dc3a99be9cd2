//! Random numbers and gradient noise on the lattice of whole numbers.
//!
//! Everything is made of integer hashes and of additions and multiplications, so it has the same bits on every machine. Coordinates
//! are in double precision: the cell of a place and the place in its cell are exact far from 0 as well.

use crate::math::hash;

/// The gradients of noise in the plane: eight directions.
const GRADIENTS_2D: [[f32; 2]; 8] = {
    const D: f32 = std::f32::consts::FRAC_1_SQRT_2;
    [
        [1.0, 0.0],
        [-1.0, 0.0],
        [0.0, 1.0],
        [0.0, -1.0],
        [D, D],
        [-D, D],
        [D, -D],
        [-D, -D],
    ]
};

/// The gradients of noise in space: the middles of the edges of a cube, four of them twice.
const GRADIENTS_3D: [[f32; 3]; 16] = [
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [-1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [-1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [-1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, -1.0, 1.0],
    [0.0, 1.0, -1.0],
    [0.0, -1.0, -1.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [0.0, -1.0, 1.0],
    [0.0, -1.0, -1.0],
];

/// The cell of a coordinate, and the place in it from 0 to 1. Cells repeat after 2^32 of them.
#[inline]
pub fn cell(x: f64) -> (u32, f32) {
    let toward_zero = x as i64;
    let whole = toward_zero - i64::from(toward_zero as f64 > x);
    (whole as u32, (x - whole as f64) as f32)
}

/// The hash of a cell of the plane or of space, well mixed.
#[inline]
pub fn hash<const D: usize>(cell: [u32; D], seed: u32) -> u32 {
    cell.iter().rev().fold(seed, |h, i| hash::mix32(h ^ i))
}

/// The weight of the corner at 1 of the unit interval, with two derivatives that are 0 at its ends.
#[inline]
fn smooth(x: f32) -> f32 {
    x * x * x * (x * (x * 6.0 - 15.0) + 10.0)
}

#[inline]
fn between(a: f32, b: f32, at: f32) -> f32 {
    a + (b - a) * at
}

/// Gradient noise in the plane, from -1 to 1, with a mean of 0.
///
/// Source: Perlin, "Improving Noise", SIGGRAPH 2002, doi:10.1145/566570.566636.
#[inline]
pub fn noise_2d(p: [f64; 2], seed: u32) -> f32 {
    let [(i, x), (j, y)] = p.map(cell);
    let row = |b: u32| {
        let of_row = hash::mix32(seed ^ j.wrapping_add(b));
        let corner = |a: u32| {
            let [gx, gy] = GRADIENTS_2D[(hash::mix32(of_row ^ i.wrapping_add(a)) >> 29) as usize];
            gx * (x - a as f32) + gy * (y - b as f32)
        };
        between(corner(0), corner(1), smooth(x))
    };
    between(row(0), row(1), smooth(y)) * std::f32::consts::SQRT_2
}

/// Gradient noise in space, from about -1 to 1, with a mean of 0. Source: that of [`noise_2d`].
#[inline]
pub fn noise_3d(p: [f64; 3], seed: u32) -> f32 {
    let [(i, x), (j, y), (k, z)] = p.map(cell);
    let layer = |c: u32| {
        let of_layer = hash::mix32(seed ^ k.wrapping_add(c));
        let row = |b: u32| {
            let of_row = hash::mix32(of_layer ^ j.wrapping_add(b));
            let corner = |a: u32| {
                let [gx, gy, gz] = GRADIENTS_3D[(hash::mix32(of_row ^ i.wrapping_add(a)) >> 28) as usize];
                gx * (x - a as f32) + gy * (y - b as f32) + gz * (z - c as f32)
            };
            between(corner(0), corner(1), smooth(x))
        };
        between(row(0), row(1), smooth(y))
    };
    between(layer(0), layer(1), smooth(z))
}
