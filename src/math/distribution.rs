//! Piecewise-constant distributions: sampling of cells in proportion to weights, and the
//! probability of each cell.
//!
//! Sums are kept rounded, and probabilities are their differences: what a cell's probability is
//! said to be is what sampling does, to the last bit.

use super::{Vec2, parallel};

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
    /// See `fill_guide`.
    guide: Vec<u32>,
}

/// Cells in rows.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant2D {
    rows: PiecewiseConstant1D,
    /// The sums of each row, as in [`PiecewiseConstant1D`].
    sums: Vec<f32>,
    /// The guides of each row, each as long as a row and one longer.
    guides: Vec<u32>,
    width: usize,
}

impl PiecewiseConstant1D {
    /// In proportion to `weights`, none of them negative; `None` where they do not add up to a
    /// number above 0.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let mut sums = vec![0.0; weights.len()];
        sum_up(weights, &mut sums)?;
        let mut guide = vec![0; sums.len() + 1];
        fill_guide(&sums, &mut guide);
        Some(Self { sums, guide })
    }

    /// The cell that the uniform number `u` in `[0, 1)` falls into.
    #[inline]
    pub fn sample(&self, u: f32) -> SampledCell {
        find(&self.sums, &self.guide, u)
    }

    /// The probability of a cell.
    #[inline]
    pub fn pmf(&self, index: usize) -> f32 {
        pmf(&self.sums, index)
    }
}

impl PiecewiseConstant2D {
    /// In proportion to the weights that `fill` writes for each of `height` rows of `width` cells;
    /// `None` where they do not add up to a number above 0.
    pub fn new([width, height]: [usize; 2], fill: impl Fn(usize, &mut [f64]) + Sync) -> Option<Self> {
        let (mut sums, mut guides) = (vec![0.0; width * height], vec![0; (width + 1) * height]);
        let rows = sums.chunks_mut(width).zip(guides.chunks_mut(width + 1));
        let totals = parallel::map(rows.enumerate(), |(row, (sums, guide))| {
            let mut weights = vec![0.0; width];
            fill(row, &mut weights);
            let total = sum_up(&weights, sums).unwrap_or(0.0);
            fill_guide(sums, guide);
            total
        });
        Some(Self {
            rows: PiecewiseConstant1D::new(&totals)?,
            sums,
            guides,
            width,
        })
    }

    /// The row by `u.y`, the cell in it by `u.x`, uniform numbers in `[0, 1)`.
    #[inline]
    pub fn sample(&self, u: Vec2) -> [SampledCell; 2] {
        let row = self.rows.sample(u.y);
        let from = row.index * (self.width + 1);
        let guide = &self.guides[from..=from + self.width];
        [find(self.row(row.index), guide, u.x), row]
    }

    /// The probability of a cell.
    #[inline]
    pub fn pmf(&self, column: usize, row: usize) -> f32 {
        let of_row = self.rows.pmf(row);
        if of_row > 0.0 {
            of_row * pmf(self.row(row), column)
        } else {
            0.0
        }
    }

    #[inline]
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

#[inline]
fn pmf(sums: &[f32], index: usize) -> f32 {
    sums[index] - index.checked_sub(1).map_or(0.0, |i| sums[i])
}

/// Fills a guide, one longer than `sums`: entry k is the number of cells whose sum is at most k / n, n being the number of
/// cells. Between two entries there is one cell on average.
///
/// Source: Chen and Asau, "On Generating Random Variates from an Empirical Distribution", AIIE Transactions 6(2), 1974.
fn fill_guide(sums: &[f32], guide: &mut [u32]) {
    let mut cell = 0;
    for (k, entry) in guide.iter_mut().enumerate() {
        let bound = k as f32 / sums.len() as f32;
        while sums.get(cell).is_some_and(|s| *s <= bound) {
            cell += 1;
        }
        *entry = cell as u32;
    }
}

/// The number of cells that [`find`] compares at once.
const COUNTED: usize = 4;

#[inline]
fn find(sums: &[f32], guide: &[u32], u: f32) -> SampledCell {
    let n = sums.len();
    // Rounding may have put `u` next to the interval it is in.
    let k = ((u * n as f32) as usize).min(n - 1);
    let k = if u < k as f32 / n as f32 { k - 1 } else { k };
    let (from, to) = (guide[k] as usize, guide[(k + 2).min(n)] as usize);
    // A few at most, most of the time, and how many is unpredictable: the first ones are counted without a branch.
    let index = match sums.get(from..from + COUNTED) {
        Some(first) if first[COUNTED - 1] > u => from + first.iter().filter(|s| **s <= u).count(),
        _ => {
            let above = sums[from..to].iter().position(|s| *s > u);
            above.map_or(to, |i| from + i).min(n - 1)
        }
    };
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
    fn guided_search_finds_what_a_search_through_all_finds() {
        for n in [1, 2, 7, 100, 1000] {
            let weight = |i: usize| match i % 13 {
                0..5 => 0.0,
                5 => 900.0,
                k => k as f64 * 1e-4,
            };
            let weights: Vec<f64> = (0..n).map(|i| weight(i + 5)).collect();
            let d = PiecewiseConstant1D::new(&weights).expect("some weight");
            let near = d.sums.iter().flat_map(|s| [s.next_down(), *s, s.next_up()]);
            let even = (0..4 * n).map(|k| k as f32 / (4 * n) as f32);
            let even = even.flat_map(|u| [u.next_down(), u, u.next_up()]);
            for u in near.chain(even).filter(|u| (0.0..1.0).contains(u)) {
                let expected = d.sums.partition_point(|s| *s <= u).min(n - 1);
                assert_eq!(d.sample(u).index, expected, "{u} of {n}");
            }
        }
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
