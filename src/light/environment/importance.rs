//! The importance map of an environment: the density of directions in light sampling.
//!
//! The picture is split into at most 256 x 128 cells, so that their table stays in the caches of a processor. A cell in which
//! the picture is nearly even is sampled uniformly by solid angle. The few others, such as those with the sun, have a table of
//! their texels.

use std::{f64::consts::PI, ops::Range};

use rayon::prelude::*;

use crate::math::{Vec2, distribution::PiecewiseConstant2D};

/// The most columns and rows of cells.
const MAX_CELLS: [usize; 2] = [256, 128];

/// The mean square of the luminance in a cell, in squares of its mean, from which on a cell has a table of its texels. It bounds
/// the variance that cells add to that of a table of all texels.
const MAX_CONTRAST: f64 = 1.1;

/// The density of directions in light sampling.
#[derive(Clone, Debug)]
pub(super) struct ImportanceMap {
    /// In texels.
    width: usize,
    /// The cosine of the angle to +y at the upper edge of each row of texels, and at the lower edge of the last.
    heights: Vec<f64>,
    /// The logarithms to base 2 of a cell's width and height in texels.
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

/// The distribution of the texels in a cell.
#[derive(Clone, Debug)]
struct Table {
    distribution: PiecewiseConstant2D,
    /// 1 over the solid angle of a texel of each row, in sr^-1.
    inverse_solid_angles: Vec<f32>,
}

/// A point of the map that was sampled.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampledPoint {
    /// The column, in texels.
    pub column: f32,
    /// The cosine of the angle to +y.
    pub height: f64,
    /// The density of the direction, in sr^-1.
    pub pdf: f32,
}

/// The picture from which an importance map is made.
struct Luminances<'a> {
    /// The mean luminances within each texel under linear interpolation, in any unit.
    texels: &'a [f32],
    width: usize,
    /// See [`ImportanceMap::heights`].
    heights: &'a [f64],
    /// The luminance up to which a direction is not sampled.
    floor: f64,
}

/// A rectangle of texels: its columns and rows.
type Area = [Range<usize>; 2];

impl Luminances<'_> {
    /// The solid angle of a texel, in sr; of one that is as high as all of `rows`.
    fn solid_angle(&self, rows: Range<usize>) -> f64 {
        2.0 * PI / self.width as f64 * (self.heights[rows.start] - self.heights[rows.end])
    }

    /// The mean luminance of all directions.
    fn mean(&self) -> f64 {
        let rows = self.texels.par_chunks(self.width).enumerate().map(|(row, texels)| {
            let total: f64 = texels.iter().map(|l| f64::from(*l)).sum();
            total * self.solid_angle(row..row + 1)
        });
        // Summed in order, so that threads do not show.
        rows.collect::<Vec<_>>().iter().sum::<f64>() / (4.0 * PI)
    }

    /// The luminances of an area's row.
    fn row(&self, columns: &Range<usize>, row: usize) -> &[f32] {
        &self.texels[row * self.width + columns.start..row * self.width + columns.end]
    }

    /// The light of a texel that is above the floor.
    fn weight(&self, luminance: f32, row: usize) -> f64 {
        (f64::from(luminance) - self.floor).max(0.0) * self.solid_angle(row..row + 1)
    }

    /// The same of an area.
    fn weight_of(&self, [columns, rows]: &Area) -> f64 {
        let row = |j| self.row(columns, j).iter().map(move |l| self.weight(*l, j));
        rows.clone().flat_map(row).sum()
    }

    /// Whether an area is sampled uniformly.
    fn is_even(&self, [columns, rows]: &Area) -> bool {
        let (mut sum, mut squares) = (0.0, 0.0);
        for l in rows.clone().flat_map(|j| self.row(columns, j)) {
            sum += f64::from(*l);
            squares += f64::from(*l) * f64::from(*l);
        }
        squares * (columns.len() * rows.len()) as f64 <= MAX_CONTRAST * sum * sum
    }

    /// The distribution of the texels in an area; `None` if none is above the floor.
    fn table(&self, [columns, rows]: &Area) -> Option<Table> {
        let distribution = PiecewiseConstant2D::new([columns.len(), rows.len()], |row, weights| {
            let row = rows.start + row;
            let texels = weights.iter_mut().zip(self.row(columns, row));
            texels.for_each(|(to, l)| *to = self.weight(*l, row));
        })?;
        let inverse = |j| (1.0 / self.solid_angle(j..j + 1)) as f32;
        Some(Table {
            distribution,
            inverse_solid_angles: rows.clone().map(inverse).collect(),
        })
    }
}

impl ImportanceMap {
    /// The importance map of a picture by the mean luminances within each texel, in any unit; `None` if no direction is brighter than
    /// the others.
    pub fn new(texels: &[f32], [width, height]: [usize; 2]) -> Option<Self> {
        let angle = |j| PI * j as f64 / height as f64;
        let heights: Vec<f64> = (0..=height).map(|j| libm::cos(angle(j))).collect();
        let mut luminances = Luminances {
            texels,
            width,
            heights: &heights,
            floor: 0.0,
        };
        // Ignores the rounding errors of a constant picture.
        luminances.floor = luminances.mean() * (1.0 + 1e-4);
        let size = [width, height];
        let shifts: [u32; 2] =
            std::array::from_fn(|k| size[k].div_ceil(MAX_CELLS[k]).next_power_of_two().trailing_zeros());
        let [columns, rows] = std::array::from_fn(|k| size[k].div_ceil(1 << shifts[k]));
        let texels = |cell: usize, k: usize| cell << shifts[k]..((cell + 1) << shifts[k]).min(size[k]);
        let area = |column, row| [texels(column, 0), texels(row, 1)];
        let distribution = PiecewiseConstant2D::new([columns, rows], |row, weights| {
            let cells = weights.iter_mut().enumerate();
            cells.for_each(|(column, to)| *to = luminances.weight_of(&area(column, row)));
        })?;
        let cell = |index: usize| {
            let (column, row) = (index % columns, index / columns);
            let (pmf, area) = (distribution.pmf(column, row), area(column, row));
            let has_table = pmf > 0.0 && !luminances.is_even(&area);
            match has_table.then(|| luminances.table(&area)).flatten() {
                Some(table) => (pmf, Some(table)),
                None => {
                    let solid_angle = luminances.solid_angle(area[1].clone()) * area[0].len() as f64;
                    ((f64::from(pmf) / solid_angle) as f32, None)
                }
            }
        };
        let all: Vec<_> = (0..columns * rows).into_par_iter().map(cell).collect();
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
        match cell.table {
            None => {
                let columns = (1 << self.shifts[0]).min(self.width - first[0]);
                let end = (first[1] + (1 << self.shifts[1])).min(self.heights.len() - 1);
                SampledPoint {
                    column: first[0] as f32 + column.within * columns as f32,
                    height: height(first[1]..end, row.within),
                    pdf: cell.density,
                }
            }
            Some(table) => {
                let table = &self.tables[table as usize];
                let [x, y] = table.distribution.sample(Vec2::new(column.within, row.within));
                let row = first[1] + y.index;
                SampledPoint {
                    column: (first[0] + x.index) as f32 + x.within,
                    height: height(row..row + 1, y.within),
                    pdf: cell.density * (x.pmf * y.pmf) * table.inverse_solid_angles[y.index],
                }
            }
        }
    }

    /// The density of the directions of a texel, in sr^-1.
    #[inline]
    pub fn pdf(&self, column: usize, row: usize) -> f32 {
        let cell = self.cells[(row >> self.shifts[1]) * self.columns + (column >> self.shifts[0])];
        match cell.table {
            None => cell.density,
            Some(table) => {
                let table = &self.tables[table as usize];
                let [x, y] = [column & ((1 << self.shifts[0]) - 1), row & ((1 << self.shifts[1]) - 1)];
                cell.density * table.distribution.pmf(x, y) * table.inverse_solid_angles[y]
            }
        }
    }
}
