//! The numbers of a texture from one range to another: more contrast, less, or turned over.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `input` | number, `[r, g, b]` or `"texture.NAME"` | | required |
//! | `from` | `[low, high]`: two different numbers of the input | | `[0, 1]` |
//! | `to` | `[low, high]`: the numbers of at least 0 that they become | | `[0, 1]` |
//! | `clamp` | whether what is beyond becomes the nearer end of `to`; if not, it goes on in a straight line, down to 0 | | `true` |
//!
//! ```toml
//! [texture.contrast]
//! remap = { input = "texture.soft", from = [0.35, 0.65], to = [0.1, 0.9] }
//!
//! [texture.soft]
//! noise = { scale = 4 }
//! ```
//!
//! Each channel is remapped by itself. `to = [0.9, 0.1]` turns the texture over. The input has its own mapping; this texture has no
//! `mapping`, `transform` or `warp`. Contrast of `noise`, `voronoi`, `brick` and `gradient` that is smaller than what a ray sees of
//! the surface is taken into account: values that are cut off darken or lighten it from afar as they do from nearby. An `image` is
//! averaged before, so that from afar it shows what its mean becomes; `checker` and `stripes` are looked up at points.

use serde::Deserialize;

use super::{Color, FindSources, Lookup, PatternKind, TextureId, Textures, lookup::EVEN_WIDTH, source::finite};
use crate::{
    math::{Rgb, Vec2},
    value::{ColorSource, Finite, List, NonNegative, Problem, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RemapDesc {
    pub input: Spanned<ColorSource>,
    pub from: Option<Spanned<List<Finite, 2>>>,
    pub to: Option<List<NonNegative, 2>>,
    #[serde(default = "yes")]
    pub clamp: bool,
}

fn yes() -> bool {
    true
}

impl RemapDesc {
    pub fn compile(&self, find: &FindSources<'_>) -> Result<Remap, Problem> {
        let from = self
            .from
            .as_ref()
            .map_or([0.0, 1.0], |from| from.get_ref().0.map(f32::from));
        if let Some(given) = &self.from
            && from[0] == from[1]
        {
            return Err(Problem::at(given.span(), "the two numbers are the same"));
        }
        Ok(Remap {
            input: find.color(&self.input)?,
            from,
            to: self.to.map_or([0.0, 1.0], |to| to.0.map(f32::from)),
            beyond: if self.clamp { Beyond::Clamp } else { Beyond::Line },
        })
    }
}

/// The values beyond the range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    Clamp,
    Line,
}

#[derive(Clone, Copy, Debug)]
pub struct Remap {
    pub input: Color,
    pub from: [f32; 2],
    pub to: [f32; 2],
    pub beyond: Beyond,
}

impl Remap {
    /// The place of an input between the ends of `from`.
    fn part(&self, number: f32) -> f64 {
        (f64::from(number) - f64::from(self.from[0])) / self.length()
    }

    /// The difference of the ends of `from`, which may be more than single precision holds.
    fn length(&self) -> f64 {
        f64::from(self.from[1]) - f64::from(self.from[0])
    }

    /// The number that a place becomes.
    fn at(&self, part: f64) -> f32 {
        let [low, high] = self.to.map(f64::from);
        (low + (high - low) * part) as f32
    }

    /// The mean of the places over an interval of this width around one.
    fn mean_part(&self, middle: f64, width: f64) -> f64 {
        match self.beyond {
            Beyond::Line => middle,
            Beyond::Clamp => super::gradient::clamped_mean(middle, width),
        }
    }

    /// The mean of the numbers that inputs around these become, with this standard deviation.
    fn seen(&self, (input, spread): (Rgb, f32)) -> Rgb {
        let width = f64::from(EVEN_WIDTH) * f64::from(spread) / self.length().abs();
        let value = |number: f32| self.at(self.mean_part(self.part(number), width));
        finite(input.map(value).max(Rgb::BLACK))
    }
}

impl PatternKind for Remap {
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        self.seen(lookup.moments(&self.input))
    }

    fn moments(&self, lookup: &Lookup<'_>) -> (Rgb, f32) {
        let input = lookup.moments(&self.input);
        let most = (self.to[1] - self.to[0]).abs();
        let spread = (f64::from(input.1) * f64::from(most) / self.length().abs()) as f32;
        let spread = match self.beyond {
            Beyond::Line => spread,
            Beyond::Clamp => spread.min(0.5 * most),
        };
        (self.seen(input), spread)
    }

    fn max_value(&self, textures: &Textures<'_>) -> Rgb {
        let most = textures.max_numbers(&self.input);
        match self.beyond {
            Beyond::Clamp => Rgb::gray(self.to[0].max(self.to[1])),
            Beyond::Line => {
                // The input is at least 0.
                let value = |number: f32| self.at(self.part(number));
                most.map(value).max(Rgb::gray(value(0.0)))
            }
        }
    }

    fn steps(&self, _textures: &Textures<'_>) -> Vec2 {
        Vec2::ZERO
    }

    fn sources(&self) -> [Option<TextureId>; 3] {
        [self.input.texture(), None, None]
    }
}
