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
//! Each channel is remapped by itself. `to = [0.9, 0.1]` turns the texture over. The input has its own mapping; this texture has no `mapping`, `transform`
//! or `warp`.
//! Contrast that is smaller than what a ray sees of the surface is taken into account: values that are cut off darken or lighten it from afar as
//! they do from nearby.

use serde::Deserialize;

use super::{Color, FindSources, Lookup, PatternKind, TextureId, Textures, lookup::EVEN_WIDTH, source::finite};
use crate::{
    math::Rgb,
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
    fn part(&self, number: f32) -> f32 {
        (number - self.from[0]) / (self.from[1] - self.from[0])
    }

    /// The mean of the places over an interval of this width around one.
    fn mean_part(&self, middle: f32, width: f32) -> f32 {
        match self.beyond {
            Beyond::Line => middle,
            Beyond::Clamp => super::gradient::clamped_mean(middle, width),
        }
    }

    /// The mean of the numbers that inputs around these become, with this standard deviation.
    fn seen(&self, (input, spread): (Rgb, f32)) -> Rgb {
        let width = EVEN_WIDTH * spread / (self.from[1] - self.from[0]).abs();
        let [low, high] = self.to;
        let value = |number: f32| low + (high - low) * self.mean_part(self.part(number), width);
        finite(input.map(value).max(Rgb::BLACK))
    }
}

impl PatternKind for Remap {
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        self.seen(lookup.moments(&self.input))
    }

    fn moments(&self, lookup: &Lookup<'_>) -> (Rgb, f32) {
        let input = lookup.moments(&self.input);
        let slope = (self.to[1] - self.to[0]) / (self.from[1] - self.from[0]);
        let most = (self.to[1] - self.to[0]).abs();
        let spread = input.1 * slope.abs();
        let spread = match self.beyond {
            Beyond::Line => spread,
            Beyond::Clamp => spread.min(0.5 * most),
        };
        (self.seen(input), spread)
    }

    fn max_value(&self, textures: &Textures<'_>) -> Rgb {
        let most = textures.max_numbers(&self.input);
        let [low, high] = self.to;
        match self.beyond {
            Beyond::Clamp => Rgb::gray(low.max(high)),
            Beyond::Line => {
                // The input is at least 0.
                let value = |number: f32| low + (high - low) * self.part(number);
                most.map(value).max(Rgb::gray(value(0.0)))
            }
        }
    }

    fn has_coordinates(&self) -> bool {
        false
    }

    fn sources(&self) -> [Option<TextureId>; 3] {
        [self.input.texture(), None, None]
    }
}
