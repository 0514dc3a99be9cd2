//! The tables that lights refer to: the profiles, textures and pictures of a scene.

use super::{picture::PictureMap, profile::Profile};
use crate::texture::Textures;

/// The tables of a scene that its lights refer to by ids.
#[derive(Clone, Copy, Debug)]
pub struct LightTables<'a> {
    pub profiles: &'a [Profile],
    pub textures: Textures<'a>,
    /// The light of the picture of this very light, if it has one.
    pub picture: Option<&'a PictureMap>,
}

impl LightTables<'_> {
    /// No tables, of lights that refer to none.
    pub const NONE: Self = Self {
        profiles: &[],
        textures: Textures {
            textures: &[],
            bitmaps: &[],
        },
        picture: None,
    };
}
