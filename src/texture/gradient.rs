//! A change from one colour to another along an axis or away from one.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `a`, `b` | number or `[r, g, b]`, scene-linear: the colours at 0 and at 1 | | 0, 1 |
//! | `along` | `"linear"`: the first coordinate s or x; `"radial"`: the distance from 0 of the first two; `"spherical"`: that of all three | | `"linear"` |
//! | `wrap` | beyond 0 and 1: `"clamp"`, `"repeat"` or `"mirror"` | | `"clamp"` |
//!
//! ```toml
//! [texture.rings]
//! gradient = { along = "radial", wrap = "repeat" }
//! mapping.object = { scale = 20, rotate = [90, 0, 0] }
//! ```
//!
//! With a mapping to three coordinates, `radial` makes tubes around the third axis and `spherical` makes shells. On average a
//! repeated or mirrored linear gradient is 0.5. It is averaged over what a ray sees of the surface.

use serde::Deserialize;

use super::{FindSources, Lookup, PatternKind, Textures, lookup::EVEN_WIDTH};
use crate::{
    math::{DVec3, Rgb},
    value::{Problem, RgbFactor},
};

/// The number that a gradient follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Along {
    #[default]
    Linear,
    Radial,
    Spherical,
}

/// The value beyond 0 and 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GradientWrap {
    #[default]
    Clamp,
    Repeat,
    Mirror,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GradientPatternDesc {
    #[serde(default = "RgbFactor::black")]
    pub a: RgbFactor,
    #[serde(default = "RgbFactor::white")]
    pub b: RgbFactor,
    #[serde(default)]
    pub along: Along,
    #[serde(default)]
    pub wrap: GradientWrap,
}

impl GradientPatternDesc {
    pub fn compile(&self, _find: &FindSources<'_>) -> Result<GradientPattern, Problem> {
        Ok(GradientPattern {
            colors: [self.a.0, self.b.0],
            along: self.along,
            wrap: self.wrap,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct GradientPattern {
    /// At 0 and at 1.
    pub colors: [Rgb; 2],
    pub along: Along,
    pub wrap: GradientWrap,
}

impl GradientWrap {
    /// The value at `x`, from 0 to 1; 0 where there is none.
    fn value(self, x: f64) -> f64 {
        let value = match self {
            Self::Clamp => x.clamp(0.0, 1.0),
            Self::Repeat => x - x.floor(),
            Self::Mirror => {
                let part = x - 2.0 * (0.5 * x).floor();
                part.min(2.0 - part)
            }
        };
        if value.is_nan() { 0.0 } else { value }
    }

    /// The integral of [`GradientWrap::value`] from 0 to `x`.
    fn integral(self, x: f64) -> f64 {
        match self {
            Self::Clamp => {
                let inside = x.clamp(0.0, 1.0);
                0.5 * inside * inside + (x - 1.0).max(0.0)
            }
            Self::Repeat => {
                let (whole, part) = (x.floor(), x - x.floor());
                0.5 * (whole + part * part)
            }
            Self::Mirror => {
                let pairs = (0.5 * x).floor();
                let part = x - 2.0 * pairs;
                let down = (part - 1.0).max(0.0);
                let up = part.min(1.0);
                pairs + 0.5 * up * up + down - 0.5 * down * down
            }
        }
    }

    /// The mean over an interval of this width around `x`; the value at `x` where the width is not finite.
    fn mean(self, x: f64, width: f64) -> f64 {
        if !(width > NARROW && width.is_finite()) {
            return self.value(x);
        }
        // Far from 0 the integrals would lose the bits that their difference needs.
        let near = match self {
            Self::Clamp => x.clamp(-width, 1.0 + width),
            Self::Repeat => x - x.floor(),
            Self::Mirror => x - 2.0 * (0.5 * x).floor(),
        };
        let mean = (self.integral(near + 0.5 * width) - self.integral(near - 0.5 * width)) / width;
        if mean.is_finite() {
            mean.clamp(0.0, 1.0)
        } else {
            self.value(near)
        }
    }
}

/// The value in the middle of an interval of this width is more exact than the difference of two integrals.
const NARROW: f64 = 1.0 / (1_u64 << 26) as f64;

/// The mean of the part of an interval around `x` that is clamped to 0 and 1.
pub(super) fn clamped_mean(x: f64, width: f64) -> f64 {
    GradientWrap::Clamp.mean(x, width)
}

impl GradientPattern {
    /// The number that the gradient follows, and its derivative by the coordinates.
    fn number(&self, p: DVec3) -> (f64, DVec3) {
        let away = match self.along {
            Along::Linear => return (p.x, DVec3::X),
            Along::Radial => p.with_z(0.0),
            Along::Spherical => p,
        };
        let distance = away.length();
        (distance, away.normalize_or_zero())
    }

    /// The number at a point, and the width of its interval over the footprint.
    fn interval(&self, lookup: &Lookup<'_>) -> (f64, f64) {
        let (x, slope) = self.number(lookup.place().xyz());
        let [a, b] = lookup.axes().map(|axis| axis.as_dvec3().dot(slope));
        (x, (a * a + b * b).sqrt())
    }
}

impl PatternKind for GradientPattern {
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        let [a, b] = self.colors;
        let (x, width) = self.interval(lookup);
        a + (b - a) * self.wrap.mean(x, width) as f32
    }

    fn moments(&self, lookup: &Lookup<'_>) -> (Rgb, f32) {
        let [a, b] = self.colors;
        let (x, width) = self.interval(lookup);
        let range = match self.wrap {
            GradientWrap::Clamp => (x + 0.5 * width).clamp(0.0, 1.0) - (x - 0.5 * width).clamp(0.0, 1.0),
            GradientWrap::Repeat | GradientWrap::Mirror => width.min(1.0),
        };
        let difference = b - a;
        let spread = difference.map(f32::abs).mean() * range as f32 / EVEN_WIDTH;
        (a + difference * self.wrap.mean(x, width) as f32, spread)
    }

    fn max_value(&self, _textures: &Textures<'_>) -> Rgb {
        let [a, b] = self.colors;
        a.max(b)
    }

    fn is_band_limited(&self) -> bool {
        true
    }
}
