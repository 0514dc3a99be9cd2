//! Non-local means: each pixel becomes a mean of those around it, weighted by how alike they are.
//!
//! Two pixels are alike as far as the squares of the differences of their surroundings are no larger than the variance of the
//! light lets expect, and their normals, albedos and depths are those of one smooth surface.

use super::{
    frame::{Frame, Guides},
    level::{levels, share},
    padded::Padded,
    signal::{Color, Signal, black},
};
use crate::{
    math::{Dispatch, VectorLoop, parallel},
    simd::Isa,
};

/// Pixels around a pixel, on each side, whose differences are averaged.
pub(super) const PATCH_RADIUS: usize = 3;

/// The radii of the two windows: a square and a disk.
const RADII: [isize; 2] = [3, 8];

/// The columns and rows that are filtered together.
const TILE: [usize; 2] = [64, 32];

const DIAMETER: usize = 2 * PATCH_RADIUS + 1;
const WIDE: usize = TILE[0] + 2 * PATCH_RADIUS;
const HIGH: usize = TILE[1] + 2 * PATCH_RADIUS;

/// The difference of two numbers with their variances: about 0 where they are of one mean, 1 and more where they are not.
#[inline(always)]
pub(super) fn difference(a: f32, b: f32, va: f32, vb: f32) -> f32 {
    /// The strictness of the test, squared.
    const STRICTNESS: f32 = 0.45 * 0.45;
    const TINY: f32 = 1e-20;
    let d = a - b;
    (d * d - (va + va.min(vb))) / (TINY + 3.0 * STRICTNESS * (va + vb))
}

/// The weight of a pixel at this distance: about exp(-d), and 0 from 4 on.
#[inline(always)]
pub(super) fn weight(distance: f32) -> f32 {
    let v = (1.0 - 0.25 * distance.max(0.0)).max(0.0);
    (v * v) * (v * v)
}

/// The means in a window of one size.
pub(super) struct Filtered {
    /// Each half, by weights that the other chose.
    pub halves: [Color; 2],
    /// The other layers, by the means of both weights.
    pub light: Vec<Color>,
    /// The sum of the squares of the weights, where they sum to 1; of both halves.
    #[cfg(test)]
    pub squares: Vec<f32>,
}

/// The means of a signal in both windows, the smaller first.
pub(super) fn filter(signal: &Signal, own: &Frame, simd: Isa) -> [Filtered; 2] {
    let size = own.size;
    let input = Input::new(signal, &own.guides, &own.alpha, size);
    let tiles: Vec<[usize; 2]> = (0..size[1])
        .step_by(TILE[1])
        .flat_map(|y| (0..size[0]).step_by(TILE[0]).map(move |x| [x, y]))
        .collect();
    let done: Vec<[Sums; 2]> = parallel::map(&tiles, |corner| {
        let mut out = None;
        simd.dispatch(Task {
            input: &input,
            corner: *corner,
            out: &mut out,
        });
        out.expect("every task sets its result")
    });
    let layers = signal.light.len();
    let mut windows = [(); 2].map(|()| Filtered {
        halves: [black(size[0] * size[1]), black(size[0] * size[1])],
        light: vec![black(size[0] * size[1]); layers],
        #[cfg(test)]
        squares: vec![0.0; size[0] * size[1]],
    });
    for (corner, sums) in tiles.iter().zip(done) {
        for (window, sums) in windows.iter_mut().zip(sums) {
            sums.put(*corner, size, window);
        }
    }
    windows
}

/// The planes with margins.
struct Input {
    halves: [[Padded; 3]; 2],
    variance: [Padded; 3],
    light: Vec<[Padded; 3]>,
    normal: [Padded; 3],
    normal_variance: Padded,
    albedo: [Padded; 3],
    albedo_variance: Padded,
    inverse_depth: Padded,
    inverse_depth_variance: Padded,
    slope: [Padded; 2],
    /// The alpha in the picture, 0 in the margin.
    covered: Padded,
    /// The brightness of each pixel, see [`levels`].
    level: Padded,
}

impl Input {
    fn new(signal: &Signal, guides: &Guides, alpha: &[f32], size: [usize; 2]) -> Self {
        let margin = RADII[1] as usize + PATCH_RADIUS;
        let plane = |values: &[f32]| Padded::new(values, size, margin + TILE[0].max(TILE[1]));
        let color = |color: &Color| std::array::from_fn(|c| plane(&color[c]));
        let slope = slope(&guides.inverse_depth, size);
        Self {
            level: plane(&levels(&signal.halves, size)),
            halves: [color(&signal.halves[0]), color(&signal.halves[1])],
            variance: color(&signal.variance),
            light: signal.light.iter().map(color).collect(),
            normal: color(&guides.normal),
            normal_variance: plane(&guides.normal_variance),
            albedo: color(&guides.albedo),
            albedo_variance: plane(&guides.albedo_variance),
            inverse_depth: plane(&guides.inverse_depth),
            inverse_depth_variance: plane(&guides.inverse_depth_variance),
            slope: [plane(&slope[0]), plane(&slope[1])],
            covered: Padded::within(alpha, size, margin + TILE[0].max(TILE[1])),
        }
    }
}

/// The change of a plane from column to column and from row to row: on each side the smaller.
fn slope(values: &[f32], [width, height]: [usize; 2]) -> [Vec<f32>; 2] {
    let least = |back: Option<f32>, forth: Option<f32>| match (back, forth) {
        (Some(a), Some(b)) if a.abs() < b.abs() => a,
        (_, Some(b)) => b,
        (Some(a), None) => a,
        (None, None) => 0.0,
    };
    let along = |step: usize, position: fn(usize, usize) -> usize, count: usize| -> Vec<f32> {
        (0..values.len())
            .map(|i| {
                let at = position(i, width);
                let back = (at > 0).then(|| values[i] - values[i - step]);
                let forth = (at + 1 < count).then(|| values[i + step] - values[i]);
                least(back, forth)
            })
            .collect()
    };
    [
        along(1, |i, width| i % width, width),
        along(width, |i, width| i / width, height),
    ]
}

/// The pixels of the windows around a pixel, by their distance, and how many of them the smaller window has.
fn offsets() -> (Vec<[isize; 2]>, usize) {
    let [small, large] = RADII;
    let square = |radius: isize| (-radius..=radius).flat_map(move |y| (-radius..=radius).map(move |x| [x, y]));
    let mut list: Vec<_> = square(small).collect();
    let inner = list.len();
    let outer = square(large).filter(|[x, y]| x.abs().max(y.abs()) > small && x * x + y * y <= large * large);
    list.extend(outer);
    (list, inner)
}

/// The sums of the pixels of a tile.
#[derive(Clone)]
struct Sums {
    /// Six planes for the halves, and three for each layer.
    planes: Vec<Vec<f32>>,
    /// The sums of the weights of each half, and of the layers.
    weights: [Vec<f32>; 3],
    #[cfg(test)]
    squares: Vec<f32>,
}

impl Sums {
    fn put(&self, [x0, y0]: [usize; 2], [width, height]: [usize; 2], window: &mut Filtered) {
        let columns = TILE[0].min(width - x0);
        let weights = |i: usize| {
            &self.weights[if i < 3 {
                0
            } else if i < 6 {
                1
            } else {
                2
            }]
        };
        let Filtered { halves, light, .. } = window;
        let out = halves.iter_mut().chain(light).flat_map(|color| color.iter_mut());
        for (i, (out, sums)) in out.zip(&self.planes).enumerate() {
            for row in 0..TILE[1].min(height - y0) {
                let line = row * TILE[0];
                let out = &mut out[(y0 + row) * width + x0..][..columns];
                let sums = sums[line..].iter().zip(&weights(i)[line..]);
                for (out, (sum, weight)) in out.iter_mut().zip(sums) {
                    *out = sum / weight.max(f32::MIN_POSITIVE);
                }
            }
        }
        #[cfg(test)]
        for row in 0..TILE[1].min(height - y0) {
            for x in 0..columns {
                let i = row * TILE[0] + x;
                window.squares[(y0 + row) * width + x0 + x] =
                    self.squares[i] / (self.weights[0][i] * self.weights[1][i]);
            }
        }
    }
}

/// The filter for the pixels of a tile.
struct Task<'a> {
    input: &'a Input,
    corner: [usize; 2],
    out: &'a mut Option<[Sums; 2]>,
}

impl VectorLoop for Task<'_> {
    #[inline(always)]
    fn run(self) {
        let input = self.input;
        let [x0, y0] = self.corner.map(|v| v as isize);
        let area = TILE[0] * TILE[1];
        let mut sums = Sums {
            planes: vec![vec![0.0; area]; 6 + 3 * input.light.len()],
            weights: [vec![0.0; area], vec![0.0; area], vec![0.0; area]],
            #[cfg(test)]
            squares: vec![0.0; area],
        };
        let mut buffers = Buffers::default();
        let (offsets, inner) = offsets();
        let mut small = None;
        for (i, offset) in offsets.into_iter().enumerate() {
            if i == inner {
                small = Some(sums.clone());
            }
            buffers.distances(input, [x0, y0], offset);
            buffers.add(input, [x0, y0], offset, &mut sums);
        }
        *self.out = small.map(|small| [small, sums]);
    }
}

/// Numbers of a tile for one offset.
struct Buffers {
    /// The differences of the halves, with the margin of a patch; then their sums over rows.
    distance: [Vec<f32>; 2],
    across: [Vec<f32>; 2],
    /// The sums over the rows of the inner patches.
    inner: [Vec<f32>; 2],
}

impl Default for Buffers {
    fn default() -> Self {
        Self {
            distance: [vec![0.0; WIDE], vec![0.0; WIDE]],
            across: [vec![0.0; TILE[0] * HIGH], vec![0.0; TILE[0] * HIGH]],
            inner: [vec![0.0; TILE[0] * HIGH], vec![0.0; TILE[0] * HIGH]],
        }
    }
}

impl Buffers {
    /// Finds the differences of pixels and those at the offset, summed over the rows of patches.
    #[inline(always)]
    fn distances(&mut self, input: &Input, [x0, y0]: [isize; 2], [dx, dy]: [isize; 2]) {
        let radius = PATCH_RADIUS as isize;
        let (x, first) = (x0 - radius, y0 - radius);
        for line in 0..HIGH {
            let y = first + line as isize;
            for (half, distance) in self.distance.iter_mut().enumerate() {
                distance.fill(0.0);
                let out = &mut distance[..WIDE];
                for c in 0..3 {
                    let plane = &input.halves[half][c];
                    let (a, b) = (plane.row(x, y, WIDE), plane.row(x + dx, y + dy, WIDE));
                    let plane = &input.variance[c];
                    let (va, vb) = (plane.row(x, y, WIDE), plane.row(x + dx, y + dy, WIDE));
                    for i in 0..WIDE {
                        out[i] += difference(a[i], b[i], va[i], vb[i]);
                    }
                }
                let across = &mut self.across[half][line * TILE[0]..][..TILE[0]];
                let inner = &mut self.inner[half][line * TILE[0]..][..TILE[0]];
                for i in 0..TILE[0] {
                    let d = &out[i..i + DIAMETER];
                    inner[i] = (d[2] + d[4]) + d[3];
                    across[i] = ((d[0] + d[6]) + (d[1] + d[5])) + inner[i];
                }
            }
        }
    }

    /// The weights of a line of pixels by the sums of one half, none larger than by the features. The inner 3 x 3 pixels of a patch
    /// must be alike too: the noise of a spot at its edge would hide that they are not.
    #[inline(always)]
    fn weights(&self, half: usize, line: usize, alike: &[f32; TILE[0]], out: &mut [f32; TILE[0]]) {
        const SCALE: f32 = 1.0 / (DIAMETER * DIAMETER) as f32;
        const INNER_SCALE: f32 = 1.0 / 9.0;
        let across = &self.across[half];
        let rows: [&[f32]; DIAMETER] = std::array::from_fn(|i| &across[(line + i) * TILE[0]..][..TILE[0]]);
        let near: [&[f32]; 3] = std::array::from_fn(|i| &self.inner[half][(line + 2 + i) * TILE[0]..][..TILE[0]]);
        for i in 0..TILE[0] {
            let sum =
                ((rows[0][i] + rows[6][i]) + (rows[1][i] + rows[5][i])) + ((rows[2][i] + rows[4][i]) + rows[3][i]);
            let inner = (near[0][i] + near[2][i]) + near[1][i];
            out[i] = weight((sum * SCALE).max(inner * INNER_SCALE)).min(alike[i]);
        }
    }

    /// Adds the pixels at the offset to the sums.
    #[inline(always)]
    fn add(&self, input: &Input, [x0, y0]: [isize; 2], [dx, dy]: [isize; 2], sums: &mut Sums) {
        let [mut first, mut second, mut both] = [[0.0; TILE[0]]; 3];
        for line in 0..TILE[1] {
            let y = y0 + line as isize;
            let mut alike = [0.0; TILE[0]];
            features(input, [x0, y], [dx, dy], &mut alike);
            let at = line * TILE[0];
            // The weights by one half are those of the other.
            self.weights(0, line, &alike, &mut second);
            self.weights(1, line, &alike, &mut first);
            for i in 0..TILE[0] {
                both[i] = 0.5 * (first[i] + second[i]);
            }
            let weights = [&first, &second, &both];
            for (sum, weights) in sums.weights.iter_mut().zip(weights) {
                let sum = &mut sum[at..at + TILE[0]];
                for i in 0..TILE[0] {
                    sum[i] += weights[i];
                }
            }
            #[cfg(test)]
            for i in 0..TILE[0] {
                sums.squares[at + i] += 0.5 * (first[i] * first[i] + second[i] * second[i]);
            }
            let colors = input.halves.iter().chain(&input.light).enumerate();
            let planes = colors.flat_map(|(i, color)| color.iter().map(move |plane| (i.min(2), plane)));
            for ((which, plane), sum) in planes.zip(&mut sums.planes) {
                let (values, weights) = (plane.row(x0 + dx, y + dy, TILE[0]), weights[which]);
                let sum = &mut sum[at..at + TILE[0]];
                for i in 0..TILE[0] {
                    sum[i] += weights[i] * values[i];
                }
            }
        }
    }
}

/// The weights of pixels at an offset by their features.
#[inline(always)]
fn features(input: &Input, [x, y]: [isize; 2], [dx, dy]: [isize; 2], out: &mut [f32; TILE[0]]) {
    /// One over the squares of the differences of normals and albedos that count as 1, and of the part by which depths may differ.
    const NORMAL: f32 = 1.0 / (0.1 * 0.1);
    const ALBEDO: f32 = 1.0 / (0.3 * 0.3);
    const DEPTH: f32 = 0.02 * 0.02;
    const TINY: f32 = 1e-30;
    const N: usize = TILE[0];
    let (from, to) = ([x, y], [x + dx, y + dy]);
    out.fill(0.0);
    add_differences(&input.normal, &input.normal_variance, (from, to), NORMAL, out);
    add_differences(&input.albedo, &input.albedo_variance, (from, to), ALBEDO, out);
    let (steps_x, steps_y) = (dx as f32, dy as f32);
    let (a, b) = (
        input.inverse_depth.row(x, y, N),
        input.inverse_depth.row(x + dx, y + dy, N),
    );
    let (va, vb) = (
        input.inverse_depth_variance.row(x, y, N),
        input.inverse_depth_variance.row(x + dx, y + dy, N),
    );
    let (sx, sy) = (input.slope[0].row(x, y, N), input.slope[1].row(x, y, N));
    let covered = input.covered.row(x + dx, y + dy, N);
    let (own, other) = (input.level.row(x, y, N), input.level.row(x + dx, y + dy, N));
    for i in 0..N {
        let d = b[i] - a[i] - (sx[i] * steps_x + sy[i] * steps_y);
        let most = a[i].max(b[i]);
        let depth = (d * d - (va[i] + vb[i])).max(0.0) / (DEPTH * most * most + TINY);
        out[i] = covered[i] * share(own[i], other[i]) * weight(out[i] + depth);
    }
}

/// Adds the squared lengths of the differences of two lines of vectors, beyond what their variances let expect, times `scale`.
#[inline(always)]
fn add_differences(
    planes: &[Padded; 3],
    variance: &Padded,
    (from, to): ([isize; 2], [isize; 2]),
    scale: f32,
    out: &mut [f32; TILE[0]],
) {
    const N: usize = TILE[0];
    let mut square = [0.0; N];
    for plane in planes {
        let (a, b) = (plane.row(from[0], from[1], N), plane.row(to[0], to[1], N));
        for i in 0..N {
            square[i] += (a[i] - b[i]) * (a[i] - b[i]);
        }
    }
    let (va, vb) = (variance.row(from[0], from[1], N), variance.row(to[0], to[1], N));
    for i in 0..N {
        out[i] += (square[i] - (va[i] + vb[i])).max(0.0) * scale;
    }
}
