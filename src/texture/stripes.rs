//! Stripes of two colours across s.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `a`, `b` | `[r, g, b]`, scene-linear | | required |
//! | `width` | width of a stripe, above 0 | units of s | required |
//!
//! ```toml
//! [texture.zebra]
//! stripes = { a = [1, 1, 1], b = [0, 0, 0], width = 0.1 }
//! mapping = "asin"
//! ```
//!
//! The colour is `a` where floor(s / width) is even.

use serde::Deserialize;

use super::{FindSources, Lookup, PatternKind, Textures};
use crate::{
    math::{DVec2, Rgb, float},
    value::{Positive, Problem, RgbFactor},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StripesDesc {
    pub a: RgbFactor,
    pub b: RgbFactor,
    pub width: Positive,
}

impl StripesDesc {
    pub fn compile(&self, _find: &FindSources<'_>) -> Result<Stripes, Problem> {
        Ok(Stripes {
            colors: [self.a.0, self.b.0],
            width: self.width.0,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Stripes {
    pub colors: [Rgb; 2],
    pub width: f32,
}

impl PatternKind for Stripes {
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        let stripe = (lookup.st().x / self.width).floor();
        self.colors[usize::from(float::is_odd(stripe))]
    }

    fn periods(&self) -> DVec2 {
        DVec2::new(2.0 * float::decimal(self.width), 0.0)
    }

    fn max_value(&self, _textures: &Textures<'_>) -> Rgb {
        let [a, b] = self.colors;
        a.max(b)
    }
}
