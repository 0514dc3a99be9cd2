//! Batches of directions: look-ups for rays without a hit, and samples for surfaces.
//!
//! Arithmetic runs on vectors. Texels are first found, then prefetched and then read, all of a batch at each step, so that the
//! latencies of the memory overlap.

use std::f32::consts::{PI, TAU};

use super::{Environment, EnvironmentLight, MapPoint, importance::SampledPoint};
use crate::{
    light::LightSample,
    math::{Dispatch, Rgb, Vec2, Vec3, VectorLoop, trig},
    simd::prefetch,
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

/// Texels that are read together.
struct Reads {
    /// See [`Corners::texels`](super::Corners).
    texels: [[u32; LANES]; 4],
    f: [[f32; LANES]; 2],
    /// The red, green and blue of each of the four.
    numbers: [[[f32; LANES]; 3]; 4],
    /// The interpolated radiances.
    colors: [[f32; LANES]; 3],
}

impl Reads {
    fn new() -> Self {
        Self {
            texels: [[0; LANES]; 4],
            f: [[0.0; LANES]; 2],
            numbers: [[[0.0; LANES]; 3]; 4],
            colors: [[0.0; LANES]; 3],
        }
    }

    fn color(&self, i: usize) -> Rgb {
        Rgb::new(self.colors[0][i], self.colors[1][i], self.colors[2][i])
    }
}

/// Computes which texels are read.
struct FindTexels<'a> {
    environment: &'a Environment,
    at: &'a MapPoints,
    reads: &'a mut Reads,
}

impl VectorLoop for FindTexels<'_> {
    #[inline(always)]
    fn run(self) {
        for i in 0..LANES {
            let corners = self.environment.corners(map_point(self.at, i));
            for (to, texel) in self.reads.texels.iter_mut().zip(&corners.texels) {
                to[i] = *texel;
            }
            (self.reads.f[0][i], self.reads.f[1][i]) = (corners.f.x, corners.f.y);
        }
    }
}

/// Interpolates the texels that were read, as [`Environment::at`] does.
struct Interpolate<'a> {
    reads: &'a mut Reads,
}

impl VectorLoop for Interpolate<'_> {
    #[inline(always)]
    fn run(self) {
        let Reads {
            f: [fx, fy],
            numbers: [a, b, c, d],
            colors,
            ..
        } = self.reads;
        for k in 0..3 {
            for i in 0..LANES {
                let upper = a[k][i] * (1.0 - fx[i]) + b[k][i] * fx[i];
                let lower = c[k][i] * (1.0 - fx[i]) + d[k][i] * fx[i];
                colors[k][i] = upper * (1.0 - fy[i]) + lower * fy[i];
            }
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
    at: &'a mut MapPoints,
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
            (self.at[0][i], self.at[1][i]) = (self.cells.columns[i], trig::atan2(r, y) / PI * height);
        }
    }
}

impl Environment {
    /// Reads the radiance at the first `count` of these points.
    fn read(&self, on: impl Dispatch, at: &MapPoints, count: usize, reads: &mut Reads) {
        on.dispatch(FindTexels {
            environment: self,
            at,
            reads,
        });
        for i in 0..count {
            // The right column is in the same line of the cache most of the time.
            prefetch(&self.texels, reads.texels[0][i] as usize);
            prefetch(&self.texels, reads.texels[2][i] as usize);
        }
        for (texels, numbers) in reads.texels.iter().zip(&mut reads.numbers) {
            let [r, g, b] = numbers;
            for i in 0..count {
                [r[i], g[i], b[i]] = self.texels[texels[i] as usize].to_array();
            }
        }
        on.dispatch(Interpolate { reads });
    }

    /// Appends the light from each of these unit directions.
    pub fn look_up(&self, on: impl Dispatch, directions: impl Iterator<Item = Vec3>, to: &mut Vec<EnvironmentLight>) {
        let (mut w, mut at): (Directions, MapPoints) = ([[0.0; LANES]; 3], [[0.0; LANES]; 2]);
        let mut reads = Reads::new();
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
            self.read(on, &at, count, &mut reads);
            to.extend((0..count).map(|i| EnvironmentLight {
                radiance: reads.color(i),
                pdf: self.pdf_at(map_point(&at, i)),
            }));
        }
    }

    /// Calls `to` with the index of each of these pairs of uniform numbers and the result of [`Environment::sample`] for it.
    pub fn sample_all(&self, on: impl Dispatch, numbers: &[Vec2], mut to: impl FnMut(usize, Option<LightSample>)) {
        let Some(importance) = &self.importance else {
            return (0..numbers.len()).for_each(|k| to(k, None));
        };
        let mut cells = Cells {
            columns: [0.0; LANES],
            heights: [0.0; LANES],
            radii: [0.0; LANES],
        };
        let (mut densities, mut w, mut at) = ([0.0; LANES], [[0.0; LANES]; 3], [[0.0; LANES]; 2]);
        let mut reads = Reads::new();
        for (numbers, first) in numbers.chunks(LANES).zip((0..).step_by(LANES)) {
            for (i, &u) in numbers.iter().enumerate() {
                let SampledPoint { column, height, pdf } = importance.sample(u);
                (densities[i], cells.columns[i], cells.heights[i]) = (pdf, column, height as f32);
                cells.radii[i] = ((1.0 - height) * (1.0 + height)).max(0.0).sqrt() as f32;
            }
            on.dispatch(FindDirections {
                environment: self,
                cells: &cells,
                w: &mut w,
                at: &mut at,
            });
            self.read(on, &at, numbers.len(), &mut reads);
            for (i, &pdf) in densities.iter().enumerate().take(numbers.len()) {
                let li = reads.color(i);
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
