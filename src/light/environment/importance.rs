//! The importance map of an environment: the density of directions in light sampling.
//!
//! The picture consists of patches: patch (i, j) lies between the centres of texels (i - 1, j - 1) and (i, j), where the
//! radiance is bilinear. Columns wrap around; the patches of the first and the last row are half as high and end at the poles.
//!
//! Patches form at most 256 x 129 cells, so that their table stays in the caches of a processor. A cell in which the picture is
//! nearly even is sampled uniformly by solid angle. The few others, such as those with the sun, have a table of their patches,
//! and the density within a patch is bilinear as well.

use std::{f64::consts::PI, ops::Range};

use super::patch::Patch;
use crate::math::{Vec2, distribution::PiecewiseConstant2D, parallel};

/// The most columns and rows of cells, but for the last row.
const MAX_CELLS: [usize; 2] = [256, 128];

/// The variance of the luminance in a cell, in squares of its mean, from which on a cell has a table of its patches.
const MAX_VARIANCE: f64 = 0.1;

/// The same times the probability of the cell: what a cell without a table adds to the variance of a sample.
const MAX_ADDED_VARIANCE: f64 = 1e-5;

/// The density of directions in light sampling.
#[derive(Clone, Debug)]
pub(super) struct ImportanceMap {
    /// In patches.
    width: usize,
    /// The cosine of the angle to +y at the upper edge of each row of patches, and at the lower edge of the last.
    heights: Vec<f64>,
    /// The logarithms to base 2 of a cell's width and height in patches.
    shifts: [u32; 2],
    distribution: PiecewiseConstant2D,
    columns: usize,
    cells: Vec<Cell>,
    tables: Vec<Table>,
}

/// A cell of the importance map.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// The density of its directions, in sr^-1; with a table, the probability of the cell.
    density: f32,
    /// The index of its table, if any.
    table: Option<u32>,
}

/// The distribution of the patches in a cell.
#[derive(Clone, Debug)]
struct Table {
    distribution: PiecewiseConstant2D,
    /// Row by row.
    patches: Vec<Patch>,
    /// In patches.
    width: usize,
    /// 1 over the solid angle of a patch of each row, in sr^-1.
    inverse_solid_angles: Vec<f32>,
}

/// A point of the map that was sampled.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampledPoint {
    /// The column from the left, in texels.
    pub column: f32,
    /// The cosine of the angle to +y.
    pub height: f64,
    /// The density of the direction, in sr^-1.
    pub pdf: f32,
}

/// The picture from which an importance map is made.
struct Luminances<'a> {
    /// The luminances at the centres of texels, in any unit.
    texels: &'a [f32],
    /// In texels.
    width: usize,
    height: usize,
    /// See [`ImportanceMap::heights`].
    heights: &'a [f64],
    /// The luminance up to which a direction is not sampled.
    floor: f64,
}

/// A rectangle of patches: its columns and rows.
type Area = [Range<usize>; 2];

impl Luminances<'_> {
    /// The solid angle of a patch, in sr; of one that is as high as all of `rows`.
    fn solid_angle(&self, rows: Range<usize>) -> f64 {
        2.0 * PI / self.width as f64 * (self.heights[rows.start] - self.heights[rows.end])
    }

    fn patch(&self, column: usize, row: usize) -> Patch {
        let left = column.checked_sub(1).unwrap_or(self.width - 1);
        // Maps of arrays within each other are calls here.
        let row_of = |j: usize| [self.texels[j * self.width + left], self.texels[j * self.width + column]];
        Patch([row_of(row.saturating_sub(1)), row_of(row.min(self.height - 1))])
    }

    /// The patches of an area's row.
    fn row(&self, columns: &Range<usize>, row: usize) -> impl Iterator<Item = Patch> {
        columns.clone().map(move |i| self.patch(i, row))
    }

    /// The patches of an area, row by row.
    fn patches(&self, [columns, rows]: &Area) -> impl Iterator<Item = Patch> {
        rows.clone().flat_map(move |j| self.row(columns, j))
    }

    /// The mean luminance of all directions.
    fn mean(&self) -> f64 {
        let rows = parallel::map(0..self.height + 1, |row| {
            let total: f64 = self.row(&(0..self.width), row).map(|patch| patch.mean()).sum();
            total * self.solid_angle(row..row + 1)
        });
        // Summed in order, so that threads do not show.
        rows.iter().sum::<f64>() / (4.0 * PI)
    }

    /// The light of a patch that is above the floor.
    fn weight(&self, patch: Patch, row: usize) -> f64 {
        (patch.mean() - self.floor).max(0.0) * self.solid_angle(row..row + 1)
    }

    /// The same of an area.
    fn weight_of(&self, [columns, rows]: &Area) -> f64 {
        let row = |j| self.row(columns, j).map(move |patch| self.weight(patch, j));
        rows.clone().flat_map(row).sum()
    }

    /// Whether an area is sampled uniformly whose probability is `pmf`.
    fn is_even(&self, area: &Area, pmf: f32) -> bool {
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        for patch in self.patches(area) {
            sum += patch.mean();
            squares += patch.mean_square();
            count += 1.0;
        }
        let max_variance = MAX_VARIANCE.min(MAX_ADDED_VARIANCE / f64::from(pmf));
        squares * count <= (1.0 + max_variance) * sum * sum
    }

    /// The distribution of the patches in an area; `None` if none is above the floor.
    fn table(&self, area: &Area) -> Option<Table> {
        let [columns, rows] = area;
        let distribution = PiecewiseConstant2D::new([columns.len(), rows.len()], |row, weights| {
            let row = rows.start + row;
            let patches = weights.iter_mut().zip(self.row(columns, row));
            patches.for_each(|(to, patch)| *to = self.weight(patch, row));
        })?;
        let inverse = |j| (1.0 / self.solid_angle(j..j + 1)) as f32;
        Some(Table {
            distribution,
            patches: self.patches(area).map(Patch::normalized).collect(),
            width: columns.len(),
            inverse_solid_angles: rows.clone().map(inverse).collect(),
        })
    }
}

impl ImportanceMap {
    /// The importance map of a picture by the luminances of its texels, in any unit; `None` if no direction is brighter than
    /// the others.
    pub fn new(texels: &[f32], [width, height]: [usize; 2]) -> Option<Self> {
        let edge = |j: usize| (j as f64 - 0.5).clamp(0.0, height as f64);
        let heights: Vec<f64> = (0..height + 2)
            .map(|j| libm::cos(PI * edge(j) / height as f64))
            .collect();
        let mut luminances = Luminances {
            texels,
            width,
            height,
            heights: &heights,
            floor: 0.0,
        };
        // Ignores the rounding errors of a constant picture.
        luminances.floor = luminances.mean() * (1.0 + 1e-4);
        let texels = [width, height];
        let shifts: [u32; 2] =
            std::array::from_fn(|k| texels[k].div_ceil(MAX_CELLS[k]).next_power_of_two().trailing_zeros());
        let patches = [width, height + 1];
        let [columns, rows] = std::array::from_fn(|k| patches[k].div_ceil(1 << shifts[k]));
        let span = |cell: usize, k: usize| cell << shifts[k]..((cell + 1) << shifts[k]).min(patches[k]);
        let area = |column, row| [span(column, 0), span(row, 1)];
        let distribution = PiecewiseConstant2D::new([columns, rows], |row, weights| {
            let cells = weights.iter_mut().enumerate();
            cells.for_each(|(column, to)| *to = luminances.weight_of(&area(column, row)));
        })?;
        let cell = |index: usize| {
            let (column, row) = (index % columns, index / columns);
            let (pmf, area) = (distribution.pmf(column, row), area(column, row));
            let has_table = pmf > 0.0 && !luminances.is_even(&area, pmf);
            match has_table.then(|| luminances.table(&area)).flatten() {
                Some(table) => (pmf, Some(table)),
                None => {
                    let solid_angle = luminances.solid_angle(area[1].clone()) * area[0].len() as f64;
                    ((f64::from(pmf) / solid_angle) as f32, None)
                }
            }
        };
        let all = parallel::map(0..columns * rows, cell);
        let (mut cells, mut tables) = (Vec::with_capacity(all.len()), Vec::new());
        for (density, table) in all {
            let index = table.is_some().then_some(tables.len() as u32);
            tables.extend(table);
            cells.push(Cell { density, table: index });
        }
        Some(Self {
            width,
            shifts,
            distribution,
            columns,
            cells,
            tables,
            heights,
        })
    }

    /// Samples a point by two uniform numbers in `[0, 1)`.
    #[inline]
    pub fn sample(&self, u: Vec2) -> SampledPoint {
        let [column, row] = self.distribution.sample(u);
        let cell = self.cells[row.index * self.columns + column.index];
        let first = [column.index << self.shifts[0], row.index << self.shifts[1]];
        // Uniform by solid angle: by the cosine, not by the angle.
        let height = |rows: Range<usize>, within: f32| {
            let [top, bottom] = [self.heights[rows.start], self.heights[rows.end]];
            top + (bottom - top) * f64::from(within)
        };
        let (column, height, pdf) = match cell.table {
            None => {
                let columns = (1 << self.shifts[0]).min(self.width - first[0]);
                let end = (first[1] + (1 << self.shifts[1])).min(self.heights.len() - 1);
                let column = first[0] as f32 + column.within * columns as f32;
                (column, height(first[1]..end, row.within), cell.density)
            }
            Some(table) => {
                let table = &self.tables[table as usize];
                let [x, y] = table.distribution.sample(Vec2::new(column.within, row.within));
                let patch = table.patches[y.index * table.width + x.index];
                let within = patch.sample(Vec2::new(x.within, y.within));
                let row = first[1] + y.index;
                let density = cell.density * (x.pmf * y.pmf) * table.inverse_solid_angles[y.index];
                (
                    (first[0] + x.index) as f32 + within.x,
                    height(row..row + 1, within.y),
                    density * patch.at(within),
                )
            }
        };
        // From the centres of texels to their edges.
        let column = column - 0.5;
        SampledPoint {
            column: if column < 0.0 {
                column + self.width as f32
            } else {
                column
            },
            height,
            pdf,
        }
    }

    /// The density of the direction of a point by its column from the left and its row from the top in texels, in sr^-1.
    #[inline]
    pub fn pdf(&self, at: Vec2) -> f32 {
        let rows = self.heights.len() - 1;
        let (x, row) = (at.x + 0.5, ((at.y + 0.5) as usize).min(rows - 1));
        let column = x as usize;
        let (column, within) = (
            if column >= self.width {
                column - self.width
            } else {
                column
            },
            x - column as f32,
        );
        let cell = self.cells[(row >> self.shifts[1]) * self.columns + (column >> self.shifts[0])];
        match cell.table {
            None => cell.density,
            Some(table) => {
                let table = &self.tables[table as usize];
                let [x, y] = [column & ((1 << self.shifts[0]) - 1), row & ((1 << self.shifts[1]) - 1)];
                let [top, bottom] = [self.heights[row], self.heights[row + 1]];
                let height = libm::cos(PI * f64::from(at.y) / (rows - 1) as f64);
                let down = ((top - height) / (top - bottom)).clamp(0.0, 1.0) as f32;
                let density = cell.density * table.distribution.pmf(x, y) * table.inverse_solid_angles[y];
                density * table.patches[y * table.width + x].at(Vec2::new(within, down))
            }
        }
    }
}
