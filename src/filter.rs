//! Pixel filters: how the samples around a pixel's centre are weighted.
//!
//! | kind | default `radius` (pixels) | source |
//! |---|---|---|
//! | `box` | 0.5 | |
//! | `tent` | 1 | |
//! | `gaussian` | 1.5 | standard deviation radius / 3, less its value at the radius |
//! | `mitchell` | 2 | Mitchell and Netravali, "Reconstruction filters in computer graphics", 1988, B = C = 1/3 |
//! | `blackman-harris` | 1.5 | Harris, "On the use of windows for harmonic analysis", 1978, 4 terms |
//!
//! The key `radius` is a number above 0. The default is `blackman-harris`, except for a scene with `samples = 1` and no
//! `filter`, whose rays go through the centre of each pixel.
//!
//! ```toml
//! [render]
//! filter.mitchell = { radius = 2 }
//! ```
//!
//! # Implementation
//!
//! Filters are importance-sampled: a sample is placed in proportion to the filter and belongs to its own pixel. Nothing is
//! splatted into neighbours, so crops and tiles cannot differ. A weight carries the sign where a filter is negative. Source:
//! Ernst, Stamminger, Greiner, "Filter importance sampling", 2006, doi:10.1109/RT.2006.280223.

use std::f32::consts::PI;

use serde::{Deserialize, Serialize, Serializer};

use crate::{
    math::{Dispatch, Vec2, VectorLoop, exponential, trig},
    value::Positive,
};

/// The description of a filter in a scene file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FilterDesc {
    Box(RadiusDesc),
    Tent(RadiusDesc),
    Gaussian(RadiusDesc),
    Mitchell(RadiusDesc),
    BlackmanHarris(RadiusDesc),
}

#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RadiusDesc {
    pub radius: Option<Positive>,
}

impl Default for FilterDesc {
    fn default() -> Self {
        Self::BlackmanHarris(RadiusDesc::default())
    }
}

impl FilterDesc {
    /// The names of all filters.
    pub const NAMES: &[&str] = &["box", "tent", "gaussian", "mitchell", "blackman-harris"];

    pub fn compile(&self) -> Filter {
        match self {
            Self::Box(r) => Filter::new(r, 0.5, |_| 1.0),
            Self::Tent(r) => Filter::new(r, 1.0, |x| 1.0 - x),
            Self::Gaussian(r) => Filter::new(r, 1.5, |x| exponential::exp(-4.5 * x * x) - exponential::exp(-4.5)),
            Self::Mitchell(r) => Filter::new(r, 2.0, |x| mitchell(2.0 * x)),
            Self::BlackmanHarris(r) => Filter::new(r, 1.5, blackman_harris),
        }
    }
}

fn mitchell(x: f32) -> f32 {
    const B: f32 = 1.0 / 3.0;
    const C: f32 = 1.0 / 3.0;
    let (x2, x3) = (x * x, x * x * x);
    let sum = if x < 1.0 {
        (12.0 - 9.0 * B - 6.0 * C) * x3 + (-18.0 + 12.0 * B + 6.0 * C) * x2 + (6.0 - 2.0 * B)
    } else {
        (-B - 6.0 * C) * x3 + (6.0 * B + 30.0 * C) * x2 + (-12.0 * B - 48.0 * C) * x + (8.0 * B + 24.0 * C)
    };
    sum / 6.0
}

fn blackman_harris(x: f32) -> f32 {
    let c = |k: f32| trig::cos(k * PI * x);
    0.35875 + 0.48829 * c(1.0) + 0.14128 * c(2.0) + 0.01168 * c(3.0)
}

/// The position of a sample around its pixel's centre, and its sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSample {
    /// From the pixel's centre, in pixels.
    pub offset: Vec2,
    /// 1, or -1 where the filter is negative.
    pub weight: f32,
}

/// Steps of the table; the step of the worst filter is off its density by less than 0.1 % of the
/// peak.
const TABLE_STEPS: usize = 1024;

/// A separable filter, ready to be sampled.
#[derive(Clone, Debug, Serialize)]
pub struct Filter {
    radius: f32,
    /// The inverse of the cumulative |filter| over [-1, 1] at even steps, in radii.
    #[serde(serialize_with = "table")]
    inverse: Box<[f32; TABLE_STEPS + 1]>,
    /// |x| beyond which the filter is negative, in radii.
    negative_beyond: f32,
}

fn table<S: Serializer>(table: &[f32; TABLE_STEPS + 1], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(table)
}

impl Default for Filter {
    fn default() -> Self {
        FilterDesc::default().compile()
    }
}

impl Filter {
    /// `profile(x)`, x from 0 to 1 in radii.
    fn new(radius: &RadiusDesc, default_radius: f32, profile: impl Fn(f32) -> f32) -> Self {
        const FINE_STEPS: usize = 8 * TABLE_STEPS;
        let at = |i: usize| (2 * i) as f32 / FINE_STEPS as f32 - 1.0;
        let mut cumulative = vec![0.0_f64; FINE_STEPS + 1];
        for i in 0..FINE_STEPS {
            let x = (at(i) + at(i + 1)) * 0.5;
            cumulative[i + 1] = cumulative[i] + f64::from(profile(x.abs()).abs());
        }
        let total = cumulative[FINE_STEPS];
        let mut bin = 0;
        let inverse = Box::new(std::array::from_fn(|k| {
            let target = total * k as f64 / TABLE_STEPS as f64;
            while bin + 1 < FINE_STEPS && cumulative[bin + 1] < target {
                bin += 1;
            }
            let width = cumulative[bin + 1] - cumulative[bin];
            let f = if width > 0.0 {
                ((target - cumulative[bin]) / width) as f32
            } else {
                0.0
            };
            at(bin) + f * 2.0 / FINE_STEPS as f32
        }));
        let negative = (0..=FINE_STEPS / 2).find(|&i| profile(i as f32 * 2.0 / FINE_STEPS as f32) < 0.0);
        Self {
            radius: radius.radius.map_or(default_radius, f32::from),
            inverse,
            negative_beyond: negative.map_or(f32::INFINITY, |i| i as f32 * 2.0 / FINE_STEPS as f32),
        }
    }

    /// By two uniform numbers in `[0, 1)`.
    #[inline(always)]
    pub fn sample(&self, u: Vec2) -> FilterSample {
        let (x, y) = (self.axis(u.x), self.axis(u.y));
        let sign = |v: f32| if v.abs() > self.negative_beyond { -1.0 } else { 1.0 };
        FilterSample {
            offset: Vec2::new(x, y) * self.radius,
            weight: sign(x) * sign(y),
        }
    }

    /// Moves `positions`, the centres of pixels, to those of the samples of `u`, whose signs are in
    /// `weights` then.
    pub fn samples(&self, on: impl Dispatch, u: &[Vec2], positions: &mut [Vec2], weights: &mut [f32]) {
        on.dispatch(FilterSamples {
            filter: self,
            u,
            positions,
            weights,
        });
    }

    #[inline(always)]
    fn axis(&self, u: f32) -> f32 {
        let at = u * TABLE_STEPS as f32;
        let i = (at as usize).min(TABLE_STEPS - 1);
        let f = at - i as f32;
        self.inverse[i] * (1.0 - f) + self.inverse[i + 1] * f
    }
}

/// [`Filter::samples`].
struct FilterSamples<'a> {
    filter: &'a Filter,
    u: &'a [Vec2],
    positions: &'a mut [Vec2],
    weights: &'a mut [f32],
}

impl VectorLoop for FilterSamples<'_> {
    #[inline(always)]
    fn run(self) {
        for ((u, position), weight) in self.u.iter().zip(self.positions).zip(self.weights) {
            let sample = self.filter.sample(*u);
            *position += sample.offset;
            *weight = sample.weight;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Plain;

    /// A profile over one axis, in radii.
    type Profile = fn(f32) -> f32;

    fn filters() -> [(FilterDesc, Profile); 5] {
        let none = RadiusDesc::default;
        [
            (FilterDesc::Box(none()), |_| 1.0),
            (FilterDesc::Tent(none()), |x| 1.0 - x),
            (FilterDesc::Gaussian(none()), |x| {
                exponential::exp(-4.5 * x * x) - exponential::exp(-4.5)
            }),
            (FilterDesc::Mitchell(none()), |x| mitchell(2.0 * x)),
            (FilterDesc::BlackmanHarris(none()), blackman_harris),
        ]
    }

    /// Signed moments of the samples along one axis equal those of the filter by quadrature.
    #[test]
    fn samples_follow_the_filter() {
        for (desc, profile) in filters() {
            let filter = desc.compile();
            let (mut sum, mut second) = (0.0_f64, 0.0_f64);
            let n = 4096;
            for i in 0..n {
                let s = filter.sample(Vec2::new((i as f32 + 0.5) / n as f32, 0.5));
                sum += f64::from(s.weight);
                second += f64::from(s.weight) * f64::from(s.offset.x).powi(2);
            }
            let (mut total, mut moment) = (0.0_f64, 0.0_f64);
            for i in 0..100_000 {
                let x = (i as f64 + 0.5) / 100_000.0;
                let f = f64::from(profile(x as f32));
                total += f;
                moment += f * (x * f64::from(filter.radius)).powi(2);
            }
            let (got, target) = (second / sum, moment / total);
            assert!((got - target).abs() < 2e-3, "{desc:?}: {got} {target}");
        }
    }

    #[test]
    fn filters_are_symmetric_and_stay_within_their_radius() {
        for (desc, _) in filters() {
            let filter = desc.compile();
            for i in 0..100 {
                let u = i as f32 / 100.0;
                let (a, b) = (filter.axis(u), filter.axis(1.0 - u));
                assert!((a + b).abs() < 2e-3 && a.abs() <= 1.0, "{desc:?} {u} {a} {b}");
            }
        }
    }

    #[test]
    fn many_samples_are_those_of_each_number() {
        for (desc, _) in filters() {
            let filter = desc.compile();
            let u: Vec<Vec2> = (0..257)
                .map(|i| Vec2::new(i as f32 / 257.0, (i as f32 * 0.37).fract()))
                .collect();
            let (mut positions, mut weights) = (vec![Vec2::new(7.5, 3.5); u.len()], vec![0.0; u.len()]);
            filter.samples(Plain, &u, &mut positions, &mut weights);
            for ((u, position), weight) in u.iter().zip(positions).zip(weights) {
                let sample = filter.sample(*u);
                assert_eq!((position, weight), (Vec2::new(7.5, 3.5) + sample.offset, sample.weight));
            }
        }
    }
}
