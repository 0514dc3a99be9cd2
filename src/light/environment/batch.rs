//! Batches of directions: look-ups for rays without a hit, and samples for surfaces.
//!
//! Arithmetic runs on vectors; texels and cells of the distribution are read in separate loops, so that their latencies overlap.

use std::f32::consts::{PI, TAU};

use super::{Environment, EnvironmentLight, MapPoint};
use crate::{
    light::LightSample,
    math::{Dispatch, Vec2, Vec3, VectorLoop, trig},
};

/// The number of directions that are looked up together.
const LANES: usize = 64;

/// Directions as arrays: their x, y and z.
type Directions = [[f32; LANES]; 3];

/// Points of the map as arrays: columns and rows.
type MapPoints = [[f32; LANES]; 2];

#[inline(always)]
fn direction(w: &Directions, i: usize) -> Vec3 {
    Vec3::new(w[0][i], w[1][i], w[2][i])
}

#[inline(always)]
fn set_direction(w: &mut Directions, i: usize, to: Vec3) {
    (w[0][i], w[1][i], w[2][i]) = (to.x, to.y, to.z);
}

fn map_point(at: &MapPoints, i: usize) -> MapPoint {
    MapPoint::new(at[0][i], at[1][i])
}

/// Computes the points of the map in given directions.
struct FindMapPoints<'a> {
    environment: &'a Environment,
    w: &'a Directions,
    at: &'a mut MapPoints,
}

impl VectorLoop for FindMapPoints<'_> {
    #[inline(always)]
    fn run(self) {
        for i in 0..LANES {
            let at = self.environment.map_point(direction(self.w, i));
            (self.at[0][i], self.at[1][i]) = (at.x, at.y);
        }
    }
}

/// Points in cells of the distribution.
struct Cells {
    /// Columns of the map.
    columns: [f32; LANES],
    /// Heights above the centre of the unit sphere, and distances from its axis.
    heights: [f32; LANES],
    radii: [f32; LANES],
}

/// Converts points in cells to directions and points of the map.
struct FindDirections<'a> {
    environment: &'a Environment,
    cells: &'a Cells,
    w: &'a mut Directions,
    rows: &'a mut [f32; LANES],
}

impl VectorLoop for FindDirections<'_> {
    #[inline(always)]
    fn run(self) {
        let (width, height) = (self.environment.width as f32, self.environment.height as f32);
        let rotation = self.environment.world_from_map;
        for i in 0..LANES {
            let (sin, cos) = trig::sin_cos_in_range(TAU * (self.cells.columns[i] / width - 0.5));
            let (r, y) = (self.cells.radii[i], self.cells.heights[i]);
            let w = (rotation * Vec3::new(r * sin, y, -r * cos)).normalize();
            set_direction(self.w, i, w);
            self.rows[i] = trig::atan2(r, y) / PI * height;
        }
    }
}

impl Environment {
    /// Appends the light from each of these unit directions.
    pub fn look_up(&self, on: impl Dispatch, directions: impl Iterator<Item = Vec3>, to: &mut Vec<EnvironmentLight>) {
        let (mut w, mut at): (Directions, MapPoints) = ([[0.0; LANES]; 3], [[0.0; LANES]; 2]);
        let mut directions = directions.peekable();
        while directions.peek().is_some() {
            let mut count = 0;
            for direction in directions.by_ref().take(LANES) {
                set_direction(&mut w, count, direction);
                count += 1;
            }
            on.dispatch(FindMapPoints {
                environment: self,
                w: &w,
                at: &mut at,
            });
            to.extend((0..count).map(|i| self.light_at(map_point(&at, i))));
        }
    }

    /// Calls `to` with the index of each of these pairs of uniform numbers and the result of [`Environment::sample`] for it.
    pub fn sample_all(&self, on: impl Dispatch, numbers: &[Vec2], mut to: impl FnMut(usize, Option<LightSample>)) {
        let Some(distribution) = &self.distribution else {
            return (0..numbers.len()).for_each(|k| to(k, None));
        };
        let mut cells = Cells {
            columns: [0.0; LANES],
            heights: [0.0; LANES],
            radii: [0.0; LANES],
        };
        let (mut densities, mut w, mut rows) = ([0.0; LANES], [[0.0; LANES]; 3], [0.0; LANES]);
        for (numbers, first) in numbers.chunks(LANES).zip((0..).step_by(LANES)) {
            for (i, &u) in numbers.iter().enumerate() {
                let [column, row] = distribution.sample(u);
                densities[i] = column.pmf * row.pmf * self.inverse_solid_angles[row.index];
                // Uniform by solid angle within the texel: by the cosine, not by the angle.
                let [top, bottom] = [self.heights[row.index], self.heights[row.index + 1]];
                let y = top + (bottom - top) * f64::from(row.within);
                cells.heights[i] = y as f32;
                cells.radii[i] = ((1.0 - y) * (1.0 + y)).max(0.0).sqrt() as f32;
                cells.columns[i] = column.index as f32 + column.within;
            }
            on.dispatch(FindDirections {
                environment: self,
                cells: &cells,
                w: &mut w,
                rows: &mut rows,
            });
            for i in 0..numbers.len() {
                let li = self.at(MapPoint::new(cells.columns[i], rows[i]));
                let pdf = densities[i];
                let sample = (pdf > 0.0 && pdf.is_finite() && !li.is_black()).then(|| LightSample {
                    wi: direction(&w, i),
                    distance: f32::INFINITY,
                    li,
                    pdf: Some(pdf),
                });
                to(first + i, sample);
            }
        }
    }
}
