//! Colours by the values of another texture: wood, marble, terrain, heat.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `input` | number or `"texture.NAME"` (channel r) | | required |
//! | `stops` | 1 to 16 tables `{ at, color }` in ascending order: the colour, scene-linear, where the input is `at` | | required |
//! | `interpolation` | between the stops: `"linear"`, `"constant"` (the colour of the last stop), or `"smooth"` | | `"linear"` |
//!
//! ```toml
//! [texture.marble]
//! ramp = { input = "texture.veins", stops = [{ at = 0, color = [0.1, 0.1, 0.12] }, { at = 0.25, color = 0.6 }, { at = 1, color = 0.85 }] }
//!
//! [texture.veins]
//! gradient = { wrap = "mirror" }
//! mapping.object = { scale = 3, rotate = [0, 0, 30] }
//! warp = { by = "texture.folds", amount = 0.8 }
//!
//! [texture.folds]
//! noise = { kind = "turbulence", scale = 1.5, octaves = 6 }
//! mapping = "object"
//! ```
//!
//! Before the first stop and behind the last the colour stays. The input has its own mapping; a ramp has no `mapping`, `transform`
//! or `warp`. Contrast of `noise`, `voronoi`, `brick` and `gradient` that is smaller than what a ray sees of the surface is taken
//! into account: from afar the ramp shows the mean of its colours over the values of the input, not the colour of the mean. An
//! `image` is averaged before, so that from afar it shows what its mean becomes; `checker` and `stripes` are looked up at points.
//!
//! **Marble** is a mirrored gradient that turbulence warps, as above. **Wood** is rings around an
//! axis, stretched and warped a little:
//!
//! ```toml
//! [texture.wood]
//! ramp = { input = "texture.rings", interpolation = "smooth", stops = [{ at = 0, color = [0.42, 0.22, 0.09] }, { at = 0.7, color = [0.25, 0.11, 0.04] }, { at = 1, color = [0.13, 0.05, 0.02] }] }
//!
//! [texture.rings]
//! gradient = { along = "radial", wrap = "repeat" }
//! mapping.object = { scale = [25, 25, 2], offset = [9, 4, 0] }
//! warp = { by = "texture.grain", amount = 0.7 }
//!
//! [texture.grain]
//! noise = { colored = true }
//! mapping.object = { scale = [4, 4, 0.6] }
//! ```

use serde::Deserialize;

use super::{FindSources, Lookup, PatternKind, Scalar, TextureId, Textures, lookup::EVEN_WIDTH, source::finite};
use crate::{
    math::{Rgb, Vec2},
    value::{Finite, Problem, RgbFactor, ScalarSource, Spanned},
};

/// The colours between stops.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    #[default]
    Linear,
    Constant,
    Smooth,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StopDesc {
    pub at: Spanned<Finite>,
    pub color: RgbFactor,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColorRampDesc {
    pub input: Spanned<ScalarSource>,
    pub stops: Spanned<Vec<StopDesc>>,
    #[serde(default)]
    pub interpolation: Interpolation,
}

/// The largest number of stops.
pub const MAX_STOPS: usize = 16;

/// The colour of a value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stop {
    pub at: f32,
    pub color: Rgb,
}

impl ColorRampDesc {
    pub fn compile(&self, find: &FindSources<'_>) -> Result<ColorRamp, Problem> {
        let given = self.stops.get_ref();
        if !(1..=MAX_STOPS).contains(&given.len()) {
            let message = format!("expected 1 to {MAX_STOPS} stops, found {}", given.len());
            return Err(Problem::at(self.stops.span(), message));
        }
        let unordered = given
            .windows(2)
            .find(|pair| pair[0].at.get_ref().0 > pair[1].at.get_ref().0);
        if let Some([_, later]) = unordered {
            return Err(Problem::at(later.at.span(), "stops go from low to high"));
        }
        let mut stops = [Stop::default(); MAX_STOPS];
        for (stop, desc) in stops.iter_mut().zip(given) {
            *stop = Stop {
                at: desc.at.get_ref().0,
                color: desc.color.0,
            };
        }
        Ok(ColorRamp {
            input: find.scalar(&self.input)?,
            stops,
            count: given.len(),
            interpolation: self.interpolation,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct ColorRamp {
    pub input: Scalar,
    /// In ascending order; those from `count` on are not used.
    pub stops: [Stop; MAX_STOPS],
    /// At least 1.
    pub count: usize,
    pub interpolation: Interpolation,
}

impl ColorRamp {
    fn stops(&self) -> &[Stop] {
        &self.stops[..self.count]
    }

    /// The colour between two stops.
    fn between(&self, a: &Stop, b: &Stop, value: f32) -> Rgb {
        // Differences may be more than single precision holds.
        let [value, from, to] = [value, a.at, b.at].map(f64::from);
        let part = ((value - from) / (to - from)).clamp(0.0, 1.0) as f32;
        let part = match self.interpolation {
            Interpolation::Linear => part,
            Interpolation::Constant => 0.0,
            Interpolation::Smooth => part * part * (3.0 - 2.0 * part),
        };
        a.color + (b.color - a.color) * part
    }

    /// The colour of a value.
    fn color(&self, value: f32) -> Rgb {
        let stops = self.stops();
        let after = stops.partition_point(|stop| stop.at <= value);
        match after {
            0 => stops[0].color,
            n if n == stops.len() => stops[n - 1].color,
            n => self.between(&stops[n - 1], &stops[n], value),
        }
    }

    /// The mean colour of the values between two, the first of them smaller.
    fn mean(&self, [low, high]: [f32; 2]) -> Rgb {
        let stops = self.stops();
        let (first, last) = (stops[0], stops[stops.len() - 1]);
        let before = (high.min(first.at) - low).max(0.0);
        let behind = (high - low.max(last.at)).max(0.0);
        let mut sum = first.color * before + last.color * behind;
        let mut total = before + behind;
        for pair in stops.windows(2) {
            let (from, to) = (low.max(pair[0].at), high.min(pair[1].at));
            if to > from {
                let at = |value| self.between(&pair[0], &pair[1], value);
                // Simpson's rule is exact for cubic functions.
                sum += (at(from) + at(0.5 * (from + to)) * 4.0 + at(to)) * ((to - from) / 6.0);
                total += to - from;
            }
        }
        sum / total
    }

    /// The mean colour of values around one with this standard deviation.
    fn seen(&self, (value, spread): (f32, f32)) -> Rgb {
        let half = 0.5 * EVEN_WIDTH * spread;
        let [low, high] = [value - half, value + half];
        if low < high && (high - low).is_finite() {
            finite(self.mean([low, high]))
        } else {
            self.color(value)
        }
    }
}

impl PatternKind for ColorRamp {
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        self.seen(lookup.scalar_moments(&self.input))
    }

    fn moments(&self, lookup: &Lookup<'_>) -> (Rgb, f32) {
        let (value, spread) = lookup.scalar_moments(&self.input);
        let [low, high] = [value - spread, value + spread].map(|value| self.color(value));
        let spread_of_colors = 0.5 * (high - low).map(f32::abs).mean();
        (self.seen((value, spread)), spread_of_colors)
    }

    fn max_value(&self, _textures: &Textures<'_>) -> Rgb {
        self.stops().iter().fold(Rgb::BLACK, |most, stop| most.max(stop.color))
    }

    fn steps(&self, _textures: &Textures<'_>) -> Vec2 {
        Vec2::ZERO
    }

    fn sources(&self) -> [Option<TextureId>; 3] {
        [self.input.texture().map(|(id, _)| id), None, None]
    }
}
