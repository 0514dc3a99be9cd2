//! A texture of one constant colour.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `color` | `[r, g, b]`, scene-linear | | required |
//!
//! ```toml
//! [texture.chalk]
//! constant = { color = [0.8, 0.8, 0.75] }
//! ```

use serde::Deserialize;

use super::{FindSources, Lookup, PatternKind, Textures};
use crate::{
    math::Rgb,
    value::{Problem, RgbFactor},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConstantDesc {
    pub color: RgbFactor,
}

impl ConstantDesc {
    pub fn compile(&self, _find: &FindSources<'_>) -> Result<Constant, Problem> {
        Ok(Constant { color: self.color.0 })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Constant {
    pub color: Rgb,
}

impl PatternKind for Constant {
    fn numbers(&self, _lookup: &Lookup<'_>) -> Rgb {
        self.color
    }

    fn max_value(&self, _textures: &Textures<'_>) -> Rgb {
        self.color
    }
}
