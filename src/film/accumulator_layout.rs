//! The layout of accumulators: which sums they hold, and which planes of a film are made of them.

use super::{
    FilmLayout,
    catchers::TileCatchers,
    passes::{Feature, PassContext, PassSource, Statistic},
    pixel_sum::{HalfSums, Moments, PixelSum},
};
use crate::scene::{FirstHit, MatteKind};

/// The order of a layout's planes in accumulators.
#[derive(Clone, Debug)]
pub struct AccumulatorLayout {
    /// The planes of sorted light: their index in the film, and the layer.
    pub(super) light: Vec<(usize, usize)>,
    pub(super) data: Vec<DataPlane>,
    /// The number of data values of a pixel.
    pub(super) data_width: usize,
    pub(super) backgrounds: Vec<f32>,
    /// The planes of mattes: their index in the film, and what they show.
    pub(super) mattes: Vec<(usize, MatteKind)>,
    /// The features whose means planes show, and the planes: their index in the film, and the index of the feature.
    pub(super) features: Vec<Feature>,
    pub(super) means: Vec<(usize, usize)>,
    pub(super) mean_variances: Vec<(usize, usize)>,
    /// The planes of the beauty of a half of the samples: their index in the film, and the half.
    pub(super) halves: Vec<(usize, usize)>,
    /// The planes of the alpha of both halves.
    pub(super) alpha_halves: Vec<usize>,
    /// The planes of the alpha with catchers as ordinary surfaces.
    pub(super) coverage: Vec<usize>,
    /// Whether accumulators hold the beauty by halves.
    pub(super) keeps_halves: bool,
    /// Whether the scene has shadow catchers.
    pub(super) has_catchers: bool,
    /// The number of the first sample of the second half.
    pub(super) second_half: u32,
    pub(super) statistics: Vec<(usize, Statistic)>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct DataPlane {
    /// Its index in the film.
    pub(super) plane: usize,
    /// The index of its first value among those of a pixel.
    pub(super) first: usize,
    pub(super) width: usize,
    pub(super) value: fn(&FirstHit, &PassContext<'_>) -> [f32; 3],
}

impl AccumulatorLayout {
    /// The order for a film with this many samples per pixel, or this many before the first
    /// [`TileAccumulator::start_second_half`](super::TileAccumulator::start_second_half).
    pub fn new(film: &FilmLayout, samples: u32) -> Self {
        let mut layout = Self {
            light: Vec::new(),
            data: Vec::new(),
            data_width: 0,
            backgrounds: Vec::new(),
            mattes: Vec::new(),
            features: Vec::new(),
            means: Vec::new(),
            mean_variances: Vec::new(),
            halves: Vec::new(),
            alpha_halves: Vec::new(),
            coverage: Vec::new(),
            keeps_halves: false,
            has_catchers: false,
            second_half: samples / 2,
            statistics: Vec::new(),
        };
        for (plane, spec) in film.planes().iter().enumerate() {
            if let Some(layer) = spec.light_layer {
                layout.light.push((plane, layer));
            }
            match spec.pass.source {
                PassSource::Integrator | PassSource::Light(_) | PassSource::LightGroup => {}
                PassSource::Matte(kind) => layout.mattes.push((plane, kind)),
                PassSource::Mean(feature) => {
                    let feature = layout.feature(feature);
                    layout.means.push((plane, feature));
                }
                PassSource::MeanVariance(feature) => {
                    let feature = layout.feature(feature);
                    layout.mean_variances.push((plane, feature));
                }
                PassSource::Half(half) => {
                    layout.halves.push((plane, half));
                    layout.keeps_halves = true;
                }
                PassSource::AlphaHalves => {
                    layout.alpha_halves.push(plane);
                    layout.keeps_halves = true;
                }
                PassSource::Coverage => layout.coverage.push(plane),
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

    /// Adds the beauty by halves, from which accumulators estimate their noise.
    pub fn with_noise(self) -> Self {
        Self {
            keeps_halves: true,
            ..self
        }
    }

    /// Adds the sums of shadow catchers.
    pub fn with_catchers(self) -> Self {
        Self {
            has_catchers: true,
            ..self
        }
    }

    /// The bytes of an accumulator per pixel, without the mattes, whose number varies.
    pub fn bytes_per_pixel(&self) -> u64 {
        let sums = 1 + self.light.len() + self.features.len();
        let data = if self.data.is_empty() { 0 } else { 1 + self.data_width };
        let mattes = 12 * self.mattes.len();
        let halves = self.feature_halves(1) + usize::from(self.keeps_halves);
        let [catchers, catcher_halves] = TileCatchers::BYTES;
        (sums * size_of::<PixelSum>()
            + catchers * self.catchers(1)
            + catcher_halves * self.catcher_halves(1)
            + halves * size_of::<HalfSums>()
            + data * size_of::<f32>()
            + self.moments(1) * size_of::<Moments>()
            + mattes) as u64
    }

    /// Returns the index of a feature, and adds it if it is new.
    pub(super) fn feature(&mut self, feature: Feature) -> usize {
        let known = self.features.iter().position(|other| *other == feature);
        known.unwrap_or_else(|| {
            self.features.push(feature);
            self.features.len() - 1
        })
    }

    /// The half, 0 or 1, of the sample with this index.
    pub(super) fn half(&self, sample: u32) -> usize {
        usize::from(sample >= self.second_half)
    }

    /// The number of sums of features by halves for this many pixels.
    pub(super) fn feature_halves(&self, pixels: usize) -> usize {
        if self.mean_variances.is_empty() {
            0
        } else {
            pixels * self.features.len()
        }
    }

    /// Whether accumulators hold sums by halves.
    pub fn is_by_halves(&self) -> bool {
        self.keeps_halves || self.feature_halves(1) > 0 || self.catcher_halves(1) > 0
    }

    /// The number of pixels of `all` that have sums of catchers.
    pub(super) fn catchers(&self, all: usize) -> usize {
        if self.has_catchers { all } else { 0 }
    }

    /// The number of pixels of `all` that have sums of catchers by halves.
    pub(super) fn catcher_halves(&self, all: usize) -> usize {
        let shows_halves = !(self.halves.is_empty() && self.alpha_halves.is_empty());
        if shows_halves { self.catchers(all) } else { 0 }
    }

    /// The number of pixels of `all` that have moments.
    pub(super) fn moments(&self, all: usize) -> usize {
        let is_variance = |(_, statistic): &(usize, Statistic)| *statistic == Statistic::Variance;
        if self.statistics.iter().any(is_variance) {
            all
        } else {
            0
        }
    }
}
