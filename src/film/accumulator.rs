//! Accumulators: the sums of a tile's samples, which become its part of a film.
//!
//! A sample belongs to its own pixel, and a pixel's samples are added in their order, so a pixel's bits do not depend on
//! tiles, threads, crops or the rounds in which a frame is rendered.

use super::{
    Film, SampleRecord, Window,
    accumulator_layout::AccumulatorLayout,
    catchers::TileCatchers,
    coverage::TileCoverage,
    features, noise,
    passes::{PassContext, Statistic},
    pixel_sum::{HalfSums, Moments, PixelSum},
    state,
};
use crate::{math::Rgb, scene::FirstHit, simd::prefetch};

/// The sums of a tile's samples so far.
#[derive(Clone, Debug)]
pub struct TileAccumulator {
    tile: Window,
    beauty: Vec<PixelSum>,
    /// The light planes of all pixels, concatenated.
    light: Vec<PixelSum>,
    /// The squared distance of each pixel's nearest sample; infinite if there is none.
    nearest: Vec<f32>,
    /// The data values of the nearest samples, concatenated.
    data: Vec<f32>,
    coverage: TileCoverage,
    /// The sums of the features of all pixels, concatenated.
    features: Vec<PixelSum>,
    /// The same by halves; empty if no pass shows their variance.
    feature_halves: Vec<HalfSums>,
    /// The halves of the beauty; empty if neither a pass nor the noise needs them.
    halves: Vec<HalfSums>,
    /// Empty if no pass shows the variance.
    moments: Vec<Moments>,
    catchers: TileCatchers,
}

impl TileAccumulator {
    pub fn new(tile: Window, layout: &AccumulatorLayout) -> Self {
        let pixels = tile.area();
        let has_data = !layout.data.is_empty();
        Self {
            tile,
            beauty: vec![PixelSum::default(); pixels],
            light: vec![PixelSum::default(); pixels * layout.light.len()],
            nearest: vec![f32::INFINITY; if has_data { pixels } else { 0 }],
            data: layout.backgrounds.repeat(pixels),
            coverage: TileCoverage::new(pixels, layout.mattes.len()),
            features: vec![PixelSum::default(); pixels * layout.features.len()],
            feature_halves: vec![HalfSums::default(); layout.feature_halves(pixels)],
            halves: vec![HalfSums::default(); if layout.keeps_halves { pixels } else { 0 }],
            moments: vec![Moments::default(); layout.moments(pixels)],
            catchers: TileCatchers::new(layout.catchers(pixels), layout.catcher_halves(pixels)),
        }
    }

    /// The pixels of the tile.
    pub fn tile(&self) -> Window {
        self.tile
    }

    /// Prefetches the sums of a pixel.
    #[inline]
    pub fn prefetch(&self, pixel: usize) {
        prefetch(&self.beauty, pixel);
    }

    /// Adds the samples of a pixel, in order; pixels are counted by rows from the tile's top left. Returns the number of samples
    /// that are not finite: their light is left out, their data is kept.
    #[inline]
    pub fn add<'a>(
        &mut self,
        layout: &AccumulatorLayout,
        context: &PassContext<'_>,
        pixel: usize,
        samples: impl Iterator<Item = SampleRecord<'a>>,
    ) -> u32 {
        let mut sum = self.beauty[pixel];
        let mut invalid = 0;
        for sample in samples {
            let is_finite = !layout.has_catchers
                || sample.without.is_none_or(Rgb::is_finite) && sample.behind.is_none_or(Rgb::is_finite);
            if is_finite && sample.l.is_finite() {
                sum.add(sample.l, sample.alpha, sample.weight);
                for (own, (_, layer)) in self.light[pixel * layout.light.len()..].iter_mut().zip(&layout.light) {
                    // Parts of a ratio have no sum.
                    let l = if sample.without.is_none() {
                        sample.light[*layer]
                    } else {
                        Rgb::BLACK
                    };
                    own.add(l, 0.0, sample.weight);
                }
                if layout.has_catchers {
                    self.catchers.add(pixel, layout.half(sample.index), &sample);
                }
                if let Some(moments) = self.moments.get_mut(pixel) {
                    moments.add(sample.l, sample.weight);
                }
                if let Some(halves) = self.halves.get_mut(pixel) {
                    halves.add(layout.half(sample.index), sample.l, sample.alpha, sample.weight);
                }
            } else {
                invalid += 1;
            }
            if layout.data_width > 0 && sample.distance_squared < self.nearest[pixel] {
                self.nearest[pixel] = sample.distance_squared;
                self.set_data(layout, context, pixel, sample.first);
            }
            if !layout.features.is_empty() {
                self.add_features(layout, context, pixel, &sample);
            }
            if !layout.mattes.is_empty() {
                self.add_mattes(layout, context, pixel, &sample);
            }
        }
        self.beauty[pixel] = sum;
        invalid
    }

    /// Adds the sums of later samples of the same tile and layout.
    pub fn append(&mut self, layout: &AccumulatorLayout, later: &Self) {
        let sums = [
            (&mut self.beauty, &later.beauty),
            (&mut self.light, &later.light),
            (&mut self.features, &later.features),
        ];
        for (own, later) in sums.into_iter().flat_map(|(own, later)| own.iter_mut().zip(later)) {
            own.append(later);
        }
        let halves = [
            (&mut self.feature_halves, &later.feature_halves),
            (&mut self.halves, &later.halves),
        ];
        for (own, later) in halves.into_iter().flat_map(|(own, later)| own.iter_mut().zip(later)) {
            own.append(later);
        }
        for (own, later) in self.moments.iter_mut().zip(&later.moments) {
            own.append(later);
        }
        // The earlier one of two samples at the same distance counts.
        let width = layout.data_width;
        for (pixel, (own, later_distance)) in self.nearest.iter_mut().zip(&later.nearest).enumerate() {
            if later_distance < own {
                *own = *later_distance;
                let values = pixel * width..(pixel + 1) * width;
                self.data[values.clone()].copy_from_slice(&later.data[values]);
            }
        }
        self.catchers.append(&later.catchers);
        self.coverage.append(&later.coverage);
    }

    /// Makes all samples so far the first half, and later ones the second.
    pub fn start_second_half(&mut self) {
        for (halves, sum) in self.halves.iter_mut().zip(&self.beauty) {
            *halves = HalfSums::of_first(sum);
        }
        for (halves, sum) in self.feature_halves.iter_mut().zip(&self.features) {
            *halves = HalfSums::of_first(sum);
        }
        self.catchers.start_second_half();
    }

    /// The estimated display error: the root of the mean over the pixels of [`noise::squared_error`]. Needs a layout
    /// [with noise](AccumulatorLayout::with_noise).
    pub fn error(&self, gain: f32) -> f64 {
        let pixels = self.beauty.iter().zip(&self.halves);
        let squares = pixels.map(|(sum, halves)| noise::squared_error(sum.rgb(), halves.mean(0), gain));
        (squares.sum::<f64>() / self.tile.area() as f64).sqrt()
    }

    fn add_features(
        &mut self,
        layout: &AccumulatorLayout,
        context: &PassContext<'_>,
        pixel: usize,
        sample: &SampleRecord<'_>,
    ) {
        let first = pixel * layout.features.len();
        for (i, feature) in (first..).zip(&layout.features) {
            let Some(value) = features::value(*feature, sample.first, context) else {
                continue;
            };
            self.features[i].add(value, 0.0, sample.weight);
            if let Some(halves) = self.feature_halves.get_mut(i) {
                halves.add(layout.half(sample.index), value, 0.0, sample.weight);
            }
        }
    }

    fn set_data(
        &mut self,
        layout: &AccumulatorLayout,
        context: &PassContext<'_>,
        pixel: usize,
        first: Option<&FirstHit>,
    ) {
        let values = &mut self.data[pixel * layout.data_width..][..layout.data_width];
        let Some(first) = first else {
            return values.copy_from_slice(&layout.backgrounds);
        };
        for plane in &layout.data {
            let value = (plane.value)(first, context);
            values[plane.first..][..plane.width].copy_from_slice(&value[..plane.width]);
        }
    }

    fn add_mattes(
        &mut self,
        layout: &AccumulatorLayout,
        context: &PassContext<'_>,
        pixel: usize,
        sample: &SampleRecord<'_>,
    ) {
        self.coverage.add_sample(pixel, sample.weight);
        let Some(first) = sample.first else { return };
        for (pass, (_, kind)) in layout.mattes.iter().enumerate() {
            let id = context.scene.mattes().id(*kind, context.scene, first);
            self.coverage.add(pixel, pass, id, sample.weight);
        }
    }

    /// Appends the sums as bytes, from which an accumulator of the same tile and layout can continue.
    pub fn write_state(&self, out: &mut Vec<u8>) {
        let Self {
            tile: _,
            beauty,
            light,
            nearest,
            data,
            coverage,
            features,
            feature_halves,
            halves,
            moments,
            catchers,
        } = self;
        state::put(out, beauty);
        state::put(out, light);
        state::put(out, nearest);
        state::put(out, data);
        state::put(out, features);
        state::put(out, feature_halves);
        state::put(out, halves);
        state::put(out, moments);
        catchers.write_state(out);
        coverage.write_state(out);
    }

    /// Reads the sums from the start of `input`, and advances it; `None` if it is too short or invalid.
    pub fn read_state(&mut self, input: &mut &[u8]) -> Option<()> {
        state::take(input, &mut self.beauty)?;
        state::take(input, &mut self.light)?;
        state::take(input, &mut self.nearest)?;
        state::take(input, &mut self.data)?;
        state::take(input, &mut self.features)?;
        state::take(input, &mut self.feature_halves)?;
        state::take(input, &mut self.halves)?;
        state::take(input, &mut self.moments)?;
        self.catchers.read_state(input)?;
        self.coverage.read_state(input)
    }

    /// Writes the current pixels into `film`.
    pub fn resolve_into(&self, layout: &AccumulatorLayout, film: &mut Film) {
        let beauty = self.beauty.iter().enumerate();
        let beauty = beauty.map(|(pixel, sum)| self.catchers.pixel(pixel, sum.resolve()));
        film.put(0, self.tile, beauty);
        let planes = layout.light.len();
        for (k, (plane, _)) in layout.light.iter().enumerate() {
            let sums = self.light.iter().skip(k).step_by(planes);
            film.put(*plane, self.tile, sums.map(PixelSum::rgb));
        }
        self.resolve_features(layout, film);
        let half = |(pixel, halves): (usize, &HalfSums), half| self.catchers.half(pixel, half, halves.resolve(half));
        for (plane, which) in &layout.halves {
            let pixels = self
                .halves
                .iter()
                .enumerate()
                .map(|pixel| Channels(half(pixel, *which), 3));
            film.put(*plane, self.tile, pixels);
        }
        for plane in &layout.alpha_halves {
            let pixels = self.halves.iter().enumerate();
            film.put(
                *plane,
                self.tile,
                pixels.map(|pixel| [0, 1].map(|which| half(pixel, which)[3])),
            );
        }
        for plane in &layout.coverage {
            film.put(*plane, self.tile, self.beauty.iter().map(|sum| [sum.resolve()[3]]));
        }
        for (plane, statistic) in &layout.statistics {
            match statistic {
                Statistic::Count => film.put(*plane, self.tile, self.beauty.iter().map(|sum| [sum.count() as f32])),
                Statistic::Variance => {
                    let pixels = self.moments.iter().zip(&self.beauty);
                    let variance = |(moments, sum): (&Moments, &PixelSum)| moments.variance(sum.rgb());
                    film.put(*plane, self.tile, pixels.map(variance));
                }
            }
        }
        for plane in &layout.data {
            let pixels = self.data.chunks_exact(layout.data_width);
            film.put(
                plane.plane,
                self.tile,
                pixels.map(|values| &values[plane.first..][..plane.width]),
            );
        }
        for (pass, (plane, _)) in layout.mattes.iter().enumerate() {
            let width = film.planes()[*plane].spec.width();
            let values = self.coverage.resolve(pass, width / 2);
            film.put(*plane, self.tile, values.chunks_exact(width));
        }
    }

    fn resolve_features(&self, layout: &AccumulatorLayout, film: &mut Film) {
        let features = layout.features.len();
        for (plane, feature) in &layout.means {
            let spec = &film.planes()[*plane].spec;
            let (width, background) = (spec.width(), spec.pass.background);
            let sums = self.features.iter().skip(*feature).step_by(features);
            let value = |sum: &PixelSum| if sum.count() > 0 { sum.rgb() } else { [background; 3] };
            film.put(*plane, self.tile, sums.map(value).map(|v| Channels(v, width)));
        }
        for (plane, feature) in &layout.mean_variances {
            let width = film.planes()[*plane].spec.width();
            let sums = self.feature_halves.iter().skip(*feature).step_by(features);
            film.put(
                *plane,
                self.tile,
                sums.map(HalfSums::variance).map(|v| Channels(v, width)),
            );
        }
    }
}

/// The first of some values.
struct Channels<const N: usize>([f32; N], usize);

impl<const N: usize> AsRef<[f32]> for Channels<N> {
    fn as_ref(&self) -> &[f32] {
        &self.0[..self.1]
    }
}
