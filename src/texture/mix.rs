//! A mixture of two textures by a third.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `a`, `b` | number, `[r, g, b]` or `"texture.NAME"` | | required |
//! | `factor` | number from 0 to 1 or `"texture.NAME"` (channel r): the share of `b` | | 0.5 |
//!
//! ```toml
//! [texture.mossy]
//! mix = { a = [0.5, 0.48, 0.45], b = [0.1, 0.2, 0.03], factor = "texture.spots" }
//!
//! [texture.spots]
//! noise = { scale = 3 }
//! mapping = "object"
//! ```
//!
//! Each channel is a (1 - f) + b f, in linear light. The textures have their own mappings; a mixture has no `mapping`,
//! `transform` or `warp`.

use serde::Deserialize;

use super::{Color, FindSources, Lookup, PatternKind, Scalar, TextureId, Textures, source::finite};
use crate::{
    math::{Rgb, Vec2},
    value::{ColorSource, Problem, ScalarSource, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MixPatternDesc {
    pub a: Spanned<ColorSource>,
    pub b: Spanned<ColorSource>,
    pub factor: Option<Spanned<ScalarSource>>,
}

impl MixPatternDesc {
    pub fn compile(&self, find: &FindSources<'_>) -> Result<MixPattern, Problem> {
        Ok(MixPattern {
            sources: [find.color(&self.a)?, find.color(&self.b)?],
            factor: match &self.factor {
                Some(factor) => find.unit_scalar(factor)?,
                None => Scalar::Constant(0.5),
            },
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct MixPattern {
    pub sources: [Color; 2],
    /// The share of the second, from 0 to 1.
    pub factor: Scalar,
}

impl PatternKind for MixPattern {
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        let factor = lookup.scalar(&self.factor).clamp(0.0, 1.0);
        let [a, b] = self.sources.each_ref().map(|source| lookup.color(source));
        finite(a * (1.0 - factor) + b * factor)
    }

    fn moments(&self, lookup: &Lookup<'_>) -> (Rgb, f32) {
        let (factor, of_factor) = lookup.scalar_moments(&self.factor);
        let factor = factor.clamp(0.0, 1.0);
        let [(a, of_a), (b, of_b)] = self.sources.each_ref().map(|source| lookup.moments(source));
        let by_factor = (b - a).map(f32::abs).mean() * of_factor;
        let spread = of_a * (1.0 - factor) + of_b * factor + by_factor;
        (finite(a * (1.0 - factor) + b * factor), spread)
    }

    fn max_value(&self, textures: &Textures<'_>) -> Rgb {
        let [a, b] = self.sources.each_ref().map(|source| textures.max_numbers(source));
        a.max(b)
    }

    fn steps(&self, _textures: &Textures<'_>) -> Vec2 {
        Vec2::ZERO
    }

    fn sources(&self) -> [Option<TextureId>; 3] {
        let [a, b] = self.sources.each_ref().map(Color::texture);
        [a, b, self.factor.texture().map(|(id, _)| id)]
    }
}
