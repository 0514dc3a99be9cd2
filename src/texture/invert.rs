//! A texture turned over: what was dark is light.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `input` | number, `[r, g, b]` or `"texture.NAME"` | | required |
//!
//! ```toml
//! [texture.smooth]
//! invert = { input = "texture.worn" }
//!
//! [texture.worn]
//! noise = { scale = 5 }
//! ```
//!
//! Each channel is 1 minus that of the input, and at least 0. The input has its own mapping; this texture has no
//! `mapping`, `transform` or `warp`.

use serde::Deserialize;

use super::{Color, FindSources, Lookup, PatternKind, TextureId, Textures};
use crate::{
    math::{Rgb, Vec2},
    value::{ColorSource, Problem, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InvertDesc {
    pub input: Spanned<ColorSource>,
}

impl InvertDesc {
    pub fn compile(&self, find: &FindSources<'_>) -> Result<Invert, Problem> {
        Ok(Invert(find.color(&self.input)?))
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Invert(pub Color);

impl PatternKind for Invert {
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        (Rgb::WHITE - lookup.color(&self.0)).max(Rgb::BLACK)
    }

    fn moments(&self, lookup: &Lookup<'_>) -> (Rgb, f32) {
        let (numbers, spread) = lookup.moments(&self.0);
        ((Rgb::WHITE - numbers).max(Rgb::BLACK), spread)
    }

    fn max_value(&self, _textures: &Textures<'_>) -> Rgb {
        Rgb::WHITE
    }

    fn steps(&self, _textures: &Textures<'_>) -> Vec2 {
        Vec2::ZERO
    }

    fn sources(&self) -> [Option<TextureId>; 3] {
        [self.0.texture(), None, None]
    }
}
