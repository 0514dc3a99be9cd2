//! The filters of FLIP: the sensitivity to contrast, and detectors of edges and points. All are products of filters of one row and
//! one column, or sums of such.

use std::f32::consts::PI;

use crate::math::parallel;

/// The numbers of a picture's channel, row by row.
#[derive(Clone)]
pub struct Plane {
    pub size: [u32; 2],
    pub values: Vec<f32>,
}

/// The weights of a row or a column around its centre.
type Kernel = Vec<f32>;

/// A filter over rows and columns, and its weight in a sum.
struct Separable {
    weight: f32,
    along_rows: Kernel,
    along_columns: Kernel,
}

pub struct Filters {
    /// For each channel of the opponent colours.
    contrast: [Vec<Separable>; 3],
    /// The Gaussian, its first and its second derivative, of a feature's width.
    gauss: Kernel,
    edge: Kernel,
    point: Kernel,
}

/// The sensitivities to contrast of each opponent channel: Gaussians by their height and width.
const CONTRAST: [&[(f32, f32)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];

/// The widest of [`CONTRAST`].
const WIDEST: f32 = 0.04;

/// The width of the eye's detector of edges, in degrees.
const FEATURE_WIDTH: f32 = 0.082;

impl Filters {
    pub fn new(pixels_per_degree: f32) -> Self {
        let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        let contrast = CONTRAST.map(|gaussians| {
            let mut filters: Vec<Separable> = gaussians
                .iter()
                .map(|&(height, width)| {
                    let kernel = sampled(radius, |x| {
                        let x = x / pixels_per_degree;
                        libm::expf(-PI * PI * x * x / width)
                    });
                    let sum: f32 = kernel.iter().sum();
                    Separable {
                        weight: height * (PI / width).sqrt() * sum * sum,
                        along_columns: scaled(&kernel, 1.0 / sum),
                        along_rows: scaled(&kernel, 1.0 / sum),
                    }
                })
                .collect();
            let sum: f32 = filters.iter().map(|f| f.weight).sum();
            filters.iter_mut().for_each(|f| f.weight /= sum);
            filters
        });
        let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
        let radius = (3.0 * deviation).ceil() as i32;
        let gauss = |x: f32| libm::expf(-x * x / (2.0 * deviation * deviation));
        let feature = |of: &dyn Fn(f32) -> f32| balanced(sampled(radius, |x| of(x) * gauss(x)));
        Self {
            contrast,
            gauss: feature(&|_| 1.0),
            edge: feature(&|x| -x),
            point: feature(&|x| x * x / (deviation * deviation) - 1.0),
        }
    }

    /// The opponent channels as far as the eye resolves them.
    pub fn contrast(&self, planes: &[Plane; 3]) -> [Plane; 3] {
        std::array::from_fn(|channel| {
            let plane = &planes[channel];
            let mut sum = vec![0.0; plane.values.len()];
            for filter in &self.contrast[channel] {
                let part = filtered(plane, &filter.along_rows, &filter.along_columns);
                for (sum, v) in sum.iter_mut().zip(part.values) {
                    *sum += filter.weight * v;
                }
            }
            Plane {
                size: plane.size,
                values: sum,
            }
        })
    }

    /// The edges and points of a gray picture.
    pub fn features(&self, gray: &Plane) -> Features {
        let strength = |kernel: &Kernel| {
            let [x, y] = [filtered(gray, kernel, &self.gauss), filtered(gray, &self.gauss, kernel)];
            let both = x.values.iter().zip(&y.values);
            both.map(|(x, y)| (x * x + y * y).sqrt()).collect()
        };
        Features {
            edges: strength(&self.edge),
            points: strength(&self.point),
        }
    }
}

/// The strength of features at each pixel.
pub struct Features {
    edges: Vec<f32>,
    points: Vec<f32>,
}

impl Features {
    /// How much a feature of pixel `i` differs, from 0 to 1.
    pub fn difference(&self, other: &Self, i: usize) -> f32 {
        let edges = (self.edges[i] - other.edges[i]).abs();
        let points = (self.points[i] - other.points[i]).abs();
        (std::f32::consts::FRAC_1_SQRT_2 * edges.max(points)).sqrt()
    }
}

fn sampled(radius: i32, of: impl Fn(f32) -> f32) -> Kernel {
    (-radius..=radius).map(|x| of(x as f32)).collect()
}

fn scaled(kernel: &[f32], by: f32) -> Kernel {
    kernel.iter().map(|w| w * by).collect()
}

/// The kernel with positive weights whose sum is 1 and negative ones whose sum is -1.
fn balanced(kernel: Kernel) -> Kernel {
    let positive: f32 = kernel.iter().filter(|w| **w > 0.0).sum();
    let negative: f32 = -kernel.iter().filter(|w| **w < 0.0).sum::<f32>();
    let sum = |w: f32| if w < 0.0 { negative } else { positive };
    kernel.iter().map(|w| w / sum(*w)).collect()
}

/// The plane through a filter; pixels beyond an edge are those of the edge.
fn filtered(plane: &Plane, along_rows: &[f32], along_columns: &[f32]) -> Plane {
    let [width, height] = plane.size.map(|side| side as usize);
    let mut rows = vec![0.0; width * height];
    let lines = rows.chunks_exact_mut(width).zip(plane.values.chunks_exact(width));
    parallel::for_each(lines, |(to, from)| {
        let radius = along_rows.len() / 2;
        let padded: Vec<f32> = (0..width + 2 * radius)
            .map(|x| from[x.saturating_sub(radius).min(width - 1)])
            .collect();
        for (i, weight) in along_rows.iter().enumerate() {
            for (to, v) in to.iter_mut().zip(&padded[i..]) {
                *to += weight * v;
            }
        }
    });
    let mut values = vec![0.0; width * height];
    parallel::for_each(values.chunks_exact_mut(width).enumerate(), |(y, to)| {
        let radius = along_columns.len() / 2;
        for (i, weight) in along_columns.iter().enumerate() {
            let row = (y + i).saturating_sub(radius).min(height - 1) * width;
            for (to, v) in to.iter_mut().zip(&rows[row..row + width]) {
                *to += weight * v;
            }
        }
    });
    Plane {
        size: plane.size,
        values,
    }
}
