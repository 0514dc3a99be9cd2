//! Points at random places, one in each cell of the lattice of whole numbers, and those that are nearest to a place.
//!
//! Source: Worley, "A Cellular Texture Basis Function", SIGGRAPH 1996, doi:10.1145/237170.237267.

use super::lattice;
use crate::math::hash;

/// The points that are nearest to a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The distances of the nearest and of the second nearest.
    pub distances: [f32; 2],
    /// The hash of the nearest point's cell.
    pub hash: u32,
}

/// Shells of cells that are visited at most. Two points lie within 2.1 of every place, so a place
/// with finite coordinates needs three.
const MOST_CELLS: i32 = 4;

/// Random numbers of a cell from 0 to below 1, one for each dimension.
fn numbers<const D: usize>(of_cell: u32) -> [f32; D] {
    let mut h = of_cell;
    [(); D].map(|()| {
        h = hash::mix32(h.wrapping_add(0x9e37_79b9));
        hash::unit_f32(h)
    })
}

/// A random colour of a cell, its channels from 0 to below 1.
pub fn color(of_cell: u32) -> [f32; 3] {
    numbers(hash::mix32(of_cell ^ 0x85eb_ca6b))
}

/// The points nearest to `p`.
pub fn nearest<const D: usize>(p: [f64; D], seed: u32) -> Nearest {
    let cells = p.map(lattice::cell);
    let mut squares = [f32::INFINITY; 2];
    let mut nearest = 0;
    let mut within = 0;
    // The places outside of the cells within a number of cells are at least as far away as their border.
    let to_border = cells.iter().fold(0.5, |least: f32, (_, x)| least.min(*x).min(1.0 - *x));
    loop {
        shell::<D>(within, |offset| {
            let mut cell = [0; D];
            for k in 0..D {
                cell[k] = cells[k].0.wrapping_add_signed(offset[k]);
            }
            let of_cell = lattice::hash(cell, seed);
            let point = numbers::<D>(of_cell);
            let mut square = 0.0;
            for k in 0..D {
                let d = offset[k] as f32 + point[k] - cells[k].1;
                square += d * d;
            }
            if square < squares[0] {
                squares = [square, squares[0]];
                nearest = of_cell;
            } else if square < squares[1] {
                squares[1] = square;
            }
        });
        let seen = within as f32 + to_border;
        if squares[1] <= seen * seen || within == MOST_CELLS {
            break;
        }
        within += 1;
    }
    Nearest {
        distances: squares.map(f32::sqrt),
        hash: nearest,
    }
}

/// Calls `visit` with each offset whose largest coordinate is `within`, in a fixed order.
#[inline]
fn shell<const D: usize>(within: i32, mut visit: impl FnMut([i32; D])) {
    let side = 2 * within + 1;
    for i in 0..side.pow(D as u32) {
        let mut rest = i;
        let offset = [(); D].map(|()| {
            let k = rest % side - within;
            rest /= side;
            k
        });
        if offset.iter().any(|k| k.abs() == within) {
            visit(offset);
        }
    }
}
