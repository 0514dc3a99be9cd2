//! Noise without a visible order: clouds, stains, dust, the grain of stone.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `a`, `b` | number or `[r, g, b]`, scene-linear: the colours where the noise is 0 and where it is 1 | | 0, 1 |
//! | `kind` | `"fbm"`, or `"turbulence"` with sharp creases | | `"fbm"` |
//! | `scale` | number above 0 | features per unit of the coordinates | 1 |
//! | `octaves` | whole number from 1 to 16: layers of noise, each finer than the one before | | 4 |
//! | `lacunarity` | number of at least 1: how much finer | | 2 |
//! | `gain` | number from 0 to 1: how much weaker | | 0.5 |
//! | `seed` | whole number: another seed is another noise | | 0 |
//! | `colored` | whether each channel has a noise of its own, so that a `warp` by it moves each coordinate differently | | `false` |
//!
//! ```toml
//! [texture.clouds]
//! noise = { a = [0.3, 0.5, 0.8], b = 1, scale = 2, octaves = 6 }
//! mapping = "object"
//! ```
//!
//! `fbm` (fractional Brownian motion) is from 0 to 1 and 0.5 on average; few of its values are below 0.2 or above 0.8, which
//! `ramp` or `remap` spreads. `turbulence` adds the absolute values of its layers: it is 0.22 on average in space (0.249 on s
//! and t), with creases where it is 0.
//!
//! With the mappings `object` and `world` the noise fills space, with others it lies on s and t. Layers whose features are smaller
//! than what a ray sees of the surface fade to their mean: from afar the surface has the mean colour without noise of the picture.
//!
//! # Implementation
//!
//! Each octave has its own offset. In space all are rotated, so that planes along the axes meet the lattice as any other plane
//! does. Source: `noise_2d`; Perlin, "An Image Synthesizer", SIGGRAPH 1985, doi:10.1145/325334.325247.

use serde::Deserialize;

use super::{
    FindSources, Lookup, PatternKind, Textures,
    band_limit::contrast,
    lattice::{noise_2d, noise_3d},
    lookup::Place,
    two_colors::TwoColors,
};
use crate::{
    math::{DMat3, DVec3, Rgb, Vec2, hash},
    value::{Count, Positive, Problem, RgbFactor, Spanned, UnitInterval},
};

/// The form of the layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseForm {
    #[default]
    Fbm,
    Turbulence,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseDesc {
    #[serde(default = "RgbFactor::black")]
    pub a: RgbFactor,
    #[serde(default = "RgbFactor::white")]
    pub b: RgbFactor,
    #[serde(default)]
    pub kind: NoiseForm,
    #[serde(default = "Positive::one")]
    pub scale: Positive,
    pub octaves: Option<Spanned<Count>>,
    pub lacunarity: Option<Spanned<Positive>>,
    pub gain: Option<UnitInterval>,
    pub seed: Option<Count>,
    #[serde(default)]
    pub colored: bool,
}

/// The channels of noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseChannels {
    /// All are the same.
    Gray,
    /// Each has a noise of its own.
    Colored,
}

const MAX_OCTAVES: u32 = 16;

impl NoiseDesc {
    pub fn compile(&self, _find: &FindSources<'_>) -> Result<Noise, Problem> {
        let octaves = match &self.octaves {
            None => 4,
            Some(given) if (1..=MAX_OCTAVES).contains(&given.get_ref().0) => given.get_ref().0,
            Some(given) => {
                let message = format!("expected 1 to {MAX_OCTAVES} octaves, found {}", given.get_ref().0);
                return Err(Problem::at(given.span(), message));
            }
        };
        let lacunarity = match &self.lacunarity {
            None => 2.0,
            Some(given) if given.get_ref().0 >= 1.0 => given.get_ref().0,
            Some(given) => {
                let message = format!("expected a number of at least 1, found {}", given.get_ref().0);
                return Err(Problem::at(given.span(), message));
            }
        };
        Ok(Noise {
            colors: TwoColors([self.a.0, self.b.0]),
            form: self.kind,
            scale: self.scale.0,
            octaves,
            lacunarity,
            gain: self.gain.map_or(0.5, |g| g.0),
            seed: self.seed.map_or(0, |s| s.0),
            channels: if self.colored {
                NoiseChannels::Colored
            } else {
                NoiseChannels::Gray
            },
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Noise {
    pub colors: TwoColors,
    pub form: NoiseForm,
    pub scale: f32,
    pub octaves: u32,
    pub lacunarity: f32,
    pub gain: f32,
    pub seed: u32,
    pub channels: NoiseChannels,
}

/// The rotation of noise in space.
const ROTATION: DMat3 = DMat3::from_cols_array(&[
    2.0 / 3.0,
    2.0 / 3.0,
    -1.0 / 3.0,
    -1.0 / 3.0,
    2.0 / 3.0,
    2.0 / 3.0,
    2.0 / 3.0,
    -1.0 / 3.0,
    2.0 / 3.0,
]);

/// The statistics of one octave.
struct Statistics {
    /// The mean of its absolute value.
    mean: f32,
    /// The standard deviations of it and of its absolute value.
    deviations: [f32; 2],
    /// The rates at which it and its absolute value lose contrast, see [`contrast`].
    falloffs: [f32; 2],
}

const IN_PLANE: Statistics = Statistics {
    mean: 0.248_9,
    deviations: [0.305, 0.176],
    falloffs: [0.4, 0.9],
};
const IN_SPACE: Statistics = Statistics {
    mean: 0.220_3,
    deviations: [0.270, 0.156],
    falloffs: [0.3, 0.7],
};

impl Statistics {
    /// The statistics of noise on s and t, or in space.
    fn of(place: Place) -> &'static Self {
        match place {
            Place::Plane(_) => &IN_PLANE,
            Place::Space(_) => &IN_SPACE,
        }
    }
}

/// An octave of noise over a footprint.
struct Layer {
    octave: u32,
    amplitude: f32,
    /// Features per unit of the coordinates.
    scale: f32,
    /// The part of its contrast that is left.
    seen: f32,
}

impl Noise {
    /// The layers of the noise over a footprint of this width and length; `falloff` is the rate at which one loses contrast, see
    /// [`contrast`].
    fn layers(&self, widths: [f32; 2], falloff: f32) -> impl Iterator<Item = Layer> {
        let first = (1.0, self.scale);
        let finer = move |(amplitude, scale): &(f32, f32)| Some((amplitude * self.gain, scale * self.lacunarity));
        let layers = std::iter::successors(Some(first), finer).zip(0..self.octaves);
        layers.map(move |((amplitude, scale), octave)| Layer {
            octave,
            amplitude,
            scale,
            seen: contrast(widths.map(|w| w * scale), falloff),
        })
    }

    /// The noise of a channel at a place, from 0 to 1, over a footprint of this width and length.
    fn value(&self, place: Place, widths: [f32; 2], channel: u32) -> f32 {
        let statistics = Statistics::of(place);
        let (mut sum, mut total) = (0.0, 0.0);
        for layer in self.layers(widths, statistics.falloffs[self.form as usize]) {
            total += layer.amplitude;
            if layer.seen > 0.0
                && let Some(place) = place.scaled(layer.scale)
            {
                let noise = self.octave(place, layer.octave, channel);
                let deviation = match self.form {
                    NoiseForm::Fbm => noise,
                    NoiseForm::Turbulence => noise.abs() - statistics.mean,
                };
                sum += layer.amplitude * layer.seen * deviation;
            }
        }
        let value = match self.form {
            NoiseForm::Fbm => 0.5 + 0.5 * sum / total,
            NoiseForm::Turbulence => statistics.mean + sum / total,
        };
        value.clamp(0.0, 1.0)
    }

    /// The standard deviation of the noise within a footprint.
    fn unseen(&self, place: Place, widths: [f32; 2]) -> f32 {
        let statistics = Statistics::of(place);
        let (mut variance, mut total) = (0.0, 0.0);
        for Layer { amplitude, seen, .. } in self.layers(widths, statistics.falloffs[self.form as usize]) {
            total += amplitude;
            variance += amplitude * amplitude * (1.0 - seen * seen).clamp(0.0, 1.0);
        }
        let range = match self.form {
            NoiseForm::Fbm => 0.5,
            NoiseForm::Turbulence => 1.0,
        };
        range * statistics.deviations[self.form as usize] * variance.sqrt() / total
    }

    /// An octave of the noise, in units of its own features.
    #[inline]
    fn octave(&self, place: Place, octave: u32, channel: u32) -> f32 {
        let [seed, x, y, z] = hash::pcg4d([self.seed, octave, channel, 0]);
        let offset = DVec3::from_array([x, y, z].map(|v| f64::from(v) / (1_u64 << 32) as f64));
        match place {
            Place::Plane(p) => noise_2d((p + offset.truncate()).to_array(), seed),
            Place::Space(p) => noise_3d((ROTATION * p + offset).to_array(), seed),
        }
    }
}

impl PatternKind for Noise {
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        let (place, widths) = (lookup.place(), lookup.widths());
        let value = |channel| self.value(place, widths, channel);
        self.colors.at(match self.channels {
            NoiseChannels::Gray => Rgb::gray(value(0)),
            NoiseChannels::Colored => Rgb::from_array([0, 1, 2].map(value)),
        })
    }

    fn moments(&self, lookup: &Lookup<'_>) -> (Rgb, f32) {
        let spread = self.colors.contrast() * self.unseen(lookup.place(), lookup.widths());
        (self.numbers(lookup), spread)
    }

    fn max_value(&self, _textures: &Textures<'_>) -> Rgb {
        self.colors.max()
    }

    fn is_band_limited(&self) -> bool {
        true
    }

    fn steps(&self, _textures: &Textures<'_>) -> Vec2 {
        let finest = (1..self.octaves).fold(self.scale, |scale, _| scale * self.lacunarity);
        Vec2::splat(finest * STEPS)
    }
}

/// Steps per feature over which a slope is measured.
const STEPS: f32 = 32.0;
