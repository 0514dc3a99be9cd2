//! A checkerboard of two colours.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `a`, `b` | `[r, g, b]`, scene-linear | | required |
//! | `scale` | number above 0 | squares per unit of s and t | 1 |
//!
//! ```toml
//! [texture.board]
//! checker = { a = [0.9, 0.9, 0.9], b = [0.1, 0.1, 0.1], scale = 8 }
//! ```
//!
//! The square with s and t in `[0, 1/scale)` has the colour `a`.

use serde::Deserialize;

use super::{FindSources, Lookup, PatternKind, Textures};
use crate::{
    math::{DVec2, Rgb, Vec2, float},
    value::{Positive, Problem, RgbFactor},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CheckerDesc {
    pub a: RgbFactor,
    pub b: RgbFactor,
    #[serde(default = "Positive::one")]
    pub scale: Positive,
}

impl CheckerDesc {
    pub fn compile(&self, _find: &FindSources<'_>) -> Result<Checker, Problem> {
        Ok(Checker {
            colors: [self.a.0, self.b.0],
            scale: self.scale.0,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Checker {
    pub colors: [Rgb; 2],
    pub scale: f32,
}

impl Checker {
    fn at(&self, st: Vec2) -> Rgb {
        let square = (st * self.scale).floor();
        self.colors[usize::from(float::is_odd(square.x + square.y))]
    }
}

impl PatternKind for Checker {
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        self.at(lookup.st())
    }

    fn periods(&self) -> DVec2 {
        DVec2::splat(2.0 / float::decimal(self.scale))
    }

    fn max_value(&self, _textures: &Textures<'_>) -> Rgb {
        let [a, b] = self.colors;
        a.max(b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_squares_differ_also_across_zero() {
        let c = Checker {
            colors: [Rgb::WHITE, Rgb::BLACK],
            scale: 2.0,
        };
        let at = |s, t| c.at(Vec2::new(s, t));
        assert_eq!(at(0.1, 0.1), Rgb::WHITE);
        assert_eq!(at(0.6, 0.1), Rgb::BLACK);
        assert_eq!(at(-0.1, 0.1), Rgb::BLACK);
        assert_eq!(at(-0.1, -0.1), Rgb::WHITE);
    }
}
