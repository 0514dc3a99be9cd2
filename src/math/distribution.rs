//! Piecewise-constant distributions: sampling of cells in proportion to weights, and the
//! probability of each cell.
//!
//! Sums are kept rounded, and probabilities are their differences: what a cell's probability is
//! said to be is what sampling does, to the last bit.

use rayon::prelude::*;

use super::Vec2;

/// A cell that was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledCell {
    pub index: usize,
    /// Its probability.
    pub pmf: f32,
    /// The position in the cell, in `[0, 1)`, uniform.
    pub within: f32,
}

/// Cells in a row.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant1D {
    /// Up to and with each cell; the last is 1.
    sums: Vec<f32>,
}

/// Cells in rows.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant2D {
    rows: PiecewiseConstant1D,
    /// The sums of each row, as in [`PiecewiseConstant1D`].
    sums: Vec<f32>,
    width: usize,
}

impl PiecewiseConstant1D {
    /// In proportion to `weights`, none of them negative; `None` where they do not add up to a
    /// number above 0.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let mut sums = vec![0.0; weights.len()];
        sum_up(weights, &mut sums).map(|_| Self { sums })
    }

    /// The cell that the uniform number `u` in `[0, 1)` falls into.
    pub fn sample(&self, u: f32) -> SampledCell {
        find(&self.sums, u)
    }

    /// The probability of a cell.
    pub fn pmf(&self, index: usize) -> f32 {
        pmf(&self.sums, index)
    }
}

impl PiecewiseConstant2D {
    /// In proportion to the weights that `fill` writes for each of `height` rows of `width` cells;
    /// `None` where they do not add up to a number above 0.
    pub fn new([width, height]: [usize; 2], fill: impl Fn(usize, &mut [f64]) + Sync) -> Option<Self> {
        let mut sums = vec![0.0; width * height];
        let totals: Vec<f64> = sums
            .par_chunks_mut(width)
            .enumerate()
            .map_init(
                || vec![0.0; width],
                |weights, (row, sums)| {
                    fill(row, weights);
                    sum_up(weights, sums).unwrap_or(0.0)
                },
            )
            .collect();
        Some(Self {
            rows: PiecewiseConstant1D::new(&totals)?,
            sums,
            width,
        })
    }

    /// The row by `u.y`, the cell in it by `u.x`, uniform numbers in `[0, 1)`.
    pub fn sample(&self, u: Vec2) -> [SampledCell; 2] {
        let row = self.rows.sample(u.y);
        [find(self.row(row.index), u.x), row]
    }

    /// The probability of a cell.
    pub fn pmf(&self, column: usize, row: usize) -> f32 {
        let of_row = self.rows.pmf(row);
        if of_row > 0.0 {
            of_row * pmf(self.row(row), column)
        } else {
            0.0
        }
    }

    fn row(&self, row: usize) -> &[f32] {
        &self.sums[row * self.width..(row + 1) * self.width]
    }
}

/// Writes the sums of `weights` as parts of their total, and returns the total if it is a number
/// above 0.
fn sum_up(weights: &[f64], sums: &mut [f32]) -> Option<f64> {
    let total: f64 = weights.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let mut sum = 0.0;
    for (to, weight) in sums.iter_mut().zip(weights) {
        sum += weight;
        *to = ((sum / total) as f32).min(1.0);
    }
    // What rounding left over belongs to the last cell that has a weight.
    if let Some(last) = weights.iter().rposition(|w| *w > 0.0) {
        sums[last..].fill(1.0);
    }
    Some(total)
}

fn pmf(sums: &[f32], index: usize) -> f32 {
    sums[index] - index.checked_sub(1).map_or(0.0, |i| sums[i])
}

fn find(sums: &[f32], u: f32) -> SampledCell {
    let index = sums.partition_point(|s| *s <= u).min(sums.len() - 1);
    let pmf = pmf(sums, index);
    let below = sums[index] - pmf;
    SampledCell {
        index,
        pmf,
        within: ((u - below) / pmf).clamp(0.0, 1.0_f32.next_down()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_found_in_proportion_and_never_without_weight() {
        let weights = [0.0, 1.0, 0.0, 3.0, 4.0, 0.0];
        let d = PiecewiseConstant1D::new(&weights).expect("some weight");
        let mut found = [0.0; 6];
        for i in 0..8000 {
            let cell = d.sample((i as f32 + 0.5) / 8000.0);
            assert_eq!(cell.pmf, d.pmf(cell.index));
            assert!((0.0..1.0).contains(&cell.within));
            found[cell.index] += 1.0 / 1000.0;
        }
        assert_eq!(found.map(|f: f64| (f * 1e6).round() / 1e6), weights);
        assert_eq!(d.sample(0.0).index, 1);
        assert_eq!(d.sample(1.0_f32.next_down()).index, 4);
    }

    #[test]
    fn probabilities_of_a_plane_add_up_to_one() {
        let weight = |x: usize, y: usize| ((x * 7 + y * 5) % 11) as f64 * if y == 2 { 0.0 } else { 1e-3 };
        let d = PiecewiseConstant2D::new([5, 4], |y, row| {
            row.iter_mut().enumerate().for_each(|(x, w)| *w = weight(x, y));
        })
        .expect("some weight");
        let total: f64 = (0..20).map(|i| weight(i % 5, i / 5)).sum();
        for i in 0..20 {
            let expected = (weight(i % 5, i / 5) / total) as f32;
            assert!((d.pmf(i % 5, i / 5) - expected).abs() < 1e-6);
        }
        let [column, row] = d.sample(Vec2::new(0.3, 0.9));
        assert!((column.pmf * row.pmf - d.pmf(column.index, row.index)).abs() < 1e-7);
    }

    #[test]
    fn nothing_is_chosen_where_nothing_weighs() {
        assert!(PiecewiseConstant1D::new(&[0.0, 0.0]).is_none());
        assert!(PiecewiseConstant1D::new(&[]).is_none());
        assert!(PiecewiseConstant1D::new(&[f64::INFINITY]).is_none());
        assert!(PiecewiseConstant2D::new([2, 2], |_, row| row.fill(0.0)).is_none());
    }
}
