//! The samples of a tile so far: what becomes the tile's part of a film.
//!
//! A sample belongs to its own pixel, and a pixel's samples are added in their order, so a pixel's bits do not depend on
//! tiles, threads, crops or the rounds in which a frame is rendered.

use super::{
    Film, FilmLayout, Window,
    coverage::TileCoverage,
    passes::{PassContext, PassSource},
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

/// The weighted sum of the samples of one pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct PixelSum {
    rgb: Rgb,
    alpha: f32,
    weight: f32,
    /// The same without signs: the fallback where the weights cancel.
    unsigned: Rgb,
    unsigned_alpha: f32,
    count: u32,
}

impl PixelSum {
    /// Adds a sample; `weight` is 1, or -1 where the filter is negative.
    #[inline]
    pub fn add(&mut self, l: Rgb, alpha: f32, weight: f32) {
        self.rgb += l * weight;
        self.alpha += alpha * weight;
        self.weight += weight;
        self.unsigned += l;
        self.unsigned_alpha += alpha;
        self.count += 1;
    }

    /// The pixel: premultiplied R, G, B and A.
    ///
    /// The weighted mean. Where so few samples were taken that negative weights leave less than a tenth of them, that
    /// mean would be noise without bound, and the plain mean stands in. Alpha lies in `[0, 1]` also where the negative
    /// lobes of a filter over- or undershoot at an edge.
    pub fn resolve(&self) -> [f32; 4] {
        let n = self.count as f32;
        let (rgb, alpha) = if self.weight >= 0.1 * n {
            (self.rgb / self.weight, self.alpha / self.weight)
        } else {
            (self.unsigned / n, self.unsigned_alpha / n)
        };
        [rgb.r, rgb.g, rgb.b, alpha.clamp(0.0, 1.0)]
    }
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
}

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
        };
        for (plane, spec) in film.planes().iter().enumerate() {
            if let Some(layer) = spec.light_layer {
                layout.light.push((plane, layer));
            }
            if let PassSource::Matte(kind) = spec.pass.source {
                layout.mattes.push((plane, kind));
            }
            if let PassSource::FirstHit(value) = spec.pass.source {
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
        layout
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
            } else {
                invalid += 1;
            }
            if layout.data_width > 0 && sample.distance_squared < self.nearest[pixel] {
                self.nearest[pixel] = sample.distance_squared;
                self.set_data(layout, context, pixel, sample.first);
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

    /// Writes the pixels as they stand into their place in `film`.
    pub fn resolve_into(&self, layout: &AccumulatorLayout, film: &mut Film) {
        let beauty = self.beauty.iter().map(PixelSum::resolve);
        film.put(0, self.tile, beauty);
        for (k, (plane, _)) in layout.light.iter().enumerate() {
            let sums = self.light.iter().skip(k).step_by(layout.light.len());
            film.put(
                *plane,
                self.tile,
                sums.map(|sum| {
                    let [r, g, b, _] = sum.resolve();
                    [r, g, b]
                }),
            );
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_stays_constant_under_signed_weights() {
        let mut sum = PixelSum::default();
        for weight in [1.0, 1.0, -1.0, 1.0] {
            sum.add(Rgb::gray(3.0), 1.0, weight);
        }
        assert_eq!(sum.resolve(), [3.0, 3.0, 3.0, 1.0]);
    }

    #[test]
    fn alpha_lies_between_0_and_1_whatever_the_lobes_of_the_filter() {
        // Four samples of a solid edge; the one with a negative weight lies on the other side of it.
        for (alphas, want) in [([1.0, 1.0, 1.0, 0.0], 1.0), ([0.0, 0.0, 0.0, 1.0], 0.0)] {
            let mut sum = PixelSum::default();
            for (alpha, weight) in alphas.into_iter().zip([1.0, 1.0, 1.0, -1.0]) {
                sum.add(Rgb::gray(1.0), alpha, weight);
            }
            assert_eq!(sum.resolve()[3], want);
        }
    }

    #[test]
    fn weights_that_cancel_leave_the_plain_mean() {
        let mut sum = PixelSum::default();
        sum.add(Rgb::gray(1.0), 1.0, 1.0);
        sum.add(Rgb::gray(3.0), 1.0, -1.0);
        assert_eq!(sum.resolve(), [2.0, 2.0, 2.0, 1.0]);
    }
}
