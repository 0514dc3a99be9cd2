//! The look-up of what lights name when they are compiled.

use super::profile::ProfileId;
use crate::{
    math::DVec3,
    texture::Color,
    value::{ColorSource, Problem, Spanned},
};

/// The place of a scene and the look-up of names, with which its lights are compiled.
pub struct LightFind<'a> {
    /// The scene's origin in world space.
    pub origin: DVec3,
    /// The profile of a file.
    pub profile: &'a dyn Fn(&Spanned<String>) -> Result<ProfileId, Problem>,
    /// The texture of a name.
    pub color: &'a dyn Fn(&Spanned<ColorSource>) -> Result<Color, Problem>,
}

fn no_profile(file: &Spanned<String>) -> Result<ProfileId, Problem> {
    Err(Problem::at(file.span(), "there are no files of profiles here"))
}

fn no_color(source: &Spanned<ColorSource>) -> Result<Color, Problem> {
    Err(Problem::at(source.span(), "there are no textures here"))
}

impl LightFind<'_> {
    /// Returns the look-up for lights that refer to nothing.
    pub fn nothing(origin: DVec3) -> Self {
        Self {
            origin,
            profile: &no_profile,
            color: &no_color,
        }
    }
}
