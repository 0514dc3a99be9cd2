//! The product of two textures: stains on paint, dirt in joints.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `a`, `b` | number, `[r, g, b]` or `"texture.NAME"` | | required |
//!
//! ```toml
//! [texture.stained]
//! multiply = { a = "texture.tiles", b = "texture.stains" }
//!
//! [texture.tiles]
//! checker = { a = [0.8, 0.8, 0.75], b = [0.2, 0.25, 0.3], scale = 8 }
//!
//! [texture.stains]
//! noise = { a = 0.4, b = 1, scale = 2 }
//! mapping = "object"
//! ```
//!
//! Each channel is multiplied, in linear light. The textures have their own mappings; a product has no `mapping`, `transform`
//! or `warp`. To multiply one texture by a colour, `factor` of its table is enough.

use serde::Deserialize;

use super::{Color, FindSources, Lookup, PatternKind, TextureId, Textures, source::finite};
use crate::{
    math::{Rgb, Vec2},
    value::{ColorSource, Problem, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultiplyDesc {
    pub a: Spanned<ColorSource>,
    pub b: Spanned<ColorSource>,
}

impl MultiplyDesc {
    pub fn compile(&self, find: &FindSources<'_>) -> Result<Multiply, Problem> {
        Ok(Multiply([find.color(&self.a)?, find.color(&self.b)?]))
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Multiply(pub [Color; 2]);

impl PatternKind for Multiply {
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        let [a, b] = self.0.each_ref().map(|source| lookup.color(source));
        finite(a * b)
    }

    fn moments(&self, lookup: &Lookup<'_>) -> (Rgb, f32) {
        let [(a, of_a), (b, of_b)] = self.0.each_ref().map(|source| lookup.moments(source));
        (finite(a * b), a.mean() * of_b + b.mean() * of_a)
    }

    fn max_value(&self, textures: &Textures<'_>) -> Rgb {
        let [a, b] = self.0.each_ref().map(|source| textures.max_numbers(source));
        // Nothing times what has no bound.
        (a * b).map(|most| if most.is_nan() { 0.0 } else { most })
    }

    fn steps(&self, _textures: &Textures<'_>) -> Vec2 {
        Vec2::ZERO
    }

    fn sources(&self) -> [Option<TextureId>; 3] {
        let [a, b] = self.0.each_ref().map(Color::texture);
        [a, b, None]
    }
}
