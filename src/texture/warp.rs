//! The displacement of a texture's coordinates by another texture.

use serde::Deserialize;

use super::{Color, FindSources, TexturePoint, Textures};
use crate::{
    math::{Rgb, Vec3},
    value::{ColorSource, Coordinate, OneOrEach, Problem, Spanned},
};

/// The warp of a texture in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WarpDesc {
    pub by: Spanned<ColorSource>,
    pub amount: OneOrEach<Coordinate, 3>,
}

impl WarpDesc {
    pub fn compile(&self, find: &FindSources<'_>) -> Result<Warp, Problem> {
        Ok(Warp {
            by: find.color(&self.by)?,
            amount: Vec3::from_array(self.amount.0.map(|v| v.0 as f32)),
        })
    }
}

/// A displacement of coordinates, each by a channel of a texture.
#[derive(Clone, Copy, Debug)]
pub struct Warp {
    pub by: Color,
    /// The displacement where a channel is 1; where it is 0.5, there is none.
    pub amount: Vec3,
}

impl Warp {
    /// The displacement at a point.
    pub(super) fn shift(&self, textures: &Textures<'_>, at: &TexturePoint) -> Vec3 {
        let numbers = textures.source_numbers(&self.by, at) * 2.0 - Rgb::WHITE;
        Vec3::from_array(numbers.to_array()) * self.amount
    }
}
