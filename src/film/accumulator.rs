//! The samples of a tile so far: what becomes the tile's part of a film.
//!
//! A sample belongs to its own pixel, and a pixel's samples are added in their order, so a pixel's bits do not depend on
//! tiles, threads, crops or the rounds in which a frame is rendered.

use super::{
    Film, FilmLayout, Window,
    coverage::TileCoverage,
    passes::{PassContext, PassSource, Statistic},
    pixel_sum::{Moments, PixelSum},
    state,
};
use crate::{
    math::Rgb,
    scene::{FirstHit, MatteKind},
};

/// A sample on its way to a tile's accumulator.
#[derive(Clone, Copy, Debug)]
pub struct SampleRecord<'a> {
    /// Radiance, in W m^-2 sr^-1.
    pub l: Rgb,
    pub alpha: f32,
    /// 1, or -1 where the pixel filter is negative.
    pub weight: f32,
    /// The squared distance from the pixel's centre, in pixels.
    pub distance_squared: f32,
    /// The first hit of its camera ray; read where the layout needs first hits.
    pub first: Option<&'a FirstHit>,
    /// Its light by layers; empty where the layout does not need them.
    pub light: &'a [Rgb],
}

/// The order of a layout's planes in accumulators.
#[derive(Clone, Debug)]
pub struct AccumulatorLayout {
    /// The planes of sorted light: their index in the film, and the layer.
    light: Vec<(usize, usize)>,
    data: Vec<DataPlane>,
    /// The number of data values of a pixel.
    data_width: usize,
    backgrounds: Vec<f32>,
    /// The planes of mattes: their index in the film, and what they show.
    mattes: Vec<(usize, MatteKind)>,
    /// The planes of colours of first hits.
    colors: Vec<ColorPlane>,
    statistics: Vec<(usize, Statistic)>,
}

/// A plane's index in the film, and the colour that it shows.
type ColorPlane = (usize, fn(&FirstHit) -> Rgb);

#[derive(Clone, Copy, Debug)]
struct DataPlane {
    /// Its index in the film.
    plane: usize,
    /// The index of its first value among those of a pixel.
    first: usize,
    width: usize,
    value: fn(&FirstHit, &PassContext<'_>) -> [f32; 3],
}

impl AccumulatorLayout {
    pub fn new(film: &FilmLayout) -> Self {
        let mut layout = Self {
            light: Vec::new(),
            data: Vec::new(),
            data_width: 0,
            backgrounds: Vec::new(),
            mattes: Vec::new(),
            colors: Vec::new(),
            statistics: Vec::new(),
        };
        for (plane, spec) in film.planes().iter().enumerate() {
            if let Some(layer) = spec.light_layer {
                layout.light.push((plane, layer));
            }
            match spec.pass.source {
                PassSource::Integrator | PassSource::Light(_) | PassSource::LightGroup => {}
                PassSource::Matte(kind) => layout.mattes.push((plane, kind)),
                PassSource::Color(color) => layout.colors.push((plane, color)),
                PassSource::Statistic(statistic) => layout.statistics.push((plane, statistic)),
                PassSource::FirstHit(value) => {
                    layout.data.push(DataPlane {
                        plane,
                        first: layout.data_width,
                        width: spec.width(),
                        value,
                    });
                    layout.data_width += spec.width();
                    layout.backgrounds.extend(vec![spec.pass.background; spec.width()]);
                }
            }
        }
        layout
    }

    /// The bytes that an accumulator takes for each pixel, without mattes that pixels share out.
    pub fn bytes_per_pixel(&self) -> u64 {
        let sums = 1 + self.light.len() + self.colors.len();
        let data = if self.data.is_empty() { 0 } else { 1 + self.data_width };
        let mattes = 12 * self.mattes.len();
        (sums * size_of::<PixelSum>() + data * size_of::<f32>() + self.moments(1) * size_of::<Moments>() + mattes)
            as u64
    }

    /// The number of pixels of `all` that have moments.
    fn moments(&self, all: usize) -> usize {
        let is_variance = |(_, statistic): &(usize, Statistic)| *statistic == Statistic::Variance;
        if self.statistics.iter().any(is_variance) {
            all
        } else {
            0
        }
    }
}

/// The samples of a tile so far.
#[derive(Clone, Debug)]
pub struct TileAccumulator {
    tile: Window,
    beauty: Vec<PixelSum>,
    /// The light planes of each pixel, one pixel after the other.
    light: Vec<PixelSum>,
    /// The squared distance of each pixel's nearest sample, infinite where there is none.
    nearest: Vec<f32>,
    /// The data values of that sample, one pixel after the other.
    data: Vec<f32>,
    coverage: TileCoverage,
    /// The colours of first hits of each pixel, one pixel after the other.
    colors: Vec<PixelSum>,
    /// Empty where no pass shows the variance.
    moments: Vec<Moments>,
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
            colors: vec![PixelSum::default(); pixels * layout.colors.len()],
            moments: vec![Moments::default(); layout.moments(pixels)],
        }
    }

    /// The pixels that it holds.
    pub fn tile(&self) -> Window {
        self.tile
    }

    /// Adds the samples of a pixel, counted by rows from the tile's top left, in order. Returns how many of them were not
    /// finite: they are left out of the light, and keep their data.
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
            if sample.l.is_finite() {
                sum.add(sample.l, sample.alpha, sample.weight);
                for (own, (_, layer)) in self.light[pixel * layout.light.len()..].iter_mut().zip(&layout.light) {
                    own.add(sample.light[*layer], 0.0, sample.weight);
                }
                if let Some(moments) = self.moments.get_mut(pixel) {
                    moments.add(sample.l, sample.weight);
                }
            } else {
                invalid += 1;
            }
            if layout.data_width > 0 && sample.distance_squared < self.nearest[pixel] {
                self.nearest[pixel] = sample.distance_squared;
                self.set_data(layout, context, pixel, sample.first);
            }
            for (own, (_, color)) in self.colors[pixel * layout.colors.len()..]
                .iter_mut()
                .zip(&layout.colors)
            {
                own.add(sample.first.map_or(Rgb::BLACK, color), 0.0, sample.weight);
            }
            if !layout.mattes.is_empty() {
                self.add_mattes(layout, context, pixel, &sample);
            }
        }
        self.beauty[pixel] = sum;
        invalid
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

    /// Appends the samples so far as bytes, from which an accumulator of the same tile and layout goes on.
    pub fn write_state(&self, out: &mut Vec<u8>) {
        let Self {
            tile: _,
            beauty,
            light,
            nearest,
            data,
            coverage,
            colors,
            moments,
        } = self;
        state::put(out, beauty);
        state::put(out, light);
        state::put(out, nearest);
        state::put(out, data);
        state::put(out, colors);
        state::put(out, moments);
        coverage.write_state(out);
    }

    /// Takes the samples so far from the start of `input`, and moves that behind them; `None` where it holds none.
    pub fn read_state(&mut self, input: &mut &[u8]) -> Option<()> {
        state::take(input, &mut self.beauty)?;
        state::take(input, &mut self.light)?;
        state::take(input, &mut self.nearest)?;
        state::take(input, &mut self.data)?;
        state::take(input, &mut self.colors)?;
        state::take(input, &mut self.moments)?;
        self.coverage.read_state(input)
    }

    /// Writes the pixels as they stand into their place in `film`.
    pub fn resolve_into(&self, layout: &AccumulatorLayout, film: &mut Film) {
        let beauty = self.beauty.iter().map(PixelSum::resolve);
        film.put(0, self.tile, beauty);
        let light = layout.light.iter().map(|(plane, _)| *plane);
        let colors = layout.colors.iter().map(|(plane, _)| *plane);
        self.resolve_sums(&self.light, light, film);
        self.resolve_sums(&self.colors, colors, film);
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

    /// Writes the values of sums, of which each pixel has one for each of `planes`.
    fn resolve_sums(&self, sums: &[PixelSum], planes: impl ExactSizeIterator<Item = usize>, film: &mut Film) {
        let count = planes.len();
        for (k, plane) in planes.enumerate() {
            film.put(plane, self.tile, sums.iter().skip(k).step_by(count).map(PixelSum::rgb));
        }
    }
}
