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

use super::{Bitmap, FindBitmap, PatternKind};
use crate::{
    math::{Rgb, Vec2},
    value::{Problem, RgbFactor},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConstantDesc {
    pub color: RgbFactor,
}

impl ConstantDesc {
    pub fn compile(&self, _find: &FindBitmap<'_>) -> Result<Constant, Problem> {
        Ok(Constant { color: self.color.0 })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Constant {
    pub color: Rgb,
}

impl PatternKind for Constant {
    fn eval(&self, _bitmaps: &[Bitmap], _st: Vec2) -> Rgb {
        self.color
    }

    fn max_value(&self, _bitmaps: &[Bitmap]) -> Rgb {
        self.color
    }
}
