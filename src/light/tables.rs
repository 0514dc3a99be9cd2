//! What lights refer to: the profiles of a scene.

use super::profile::{Profile, ProfileId};
use crate::{
    math::DVec3,
    value::{Problem, Spanned},
};

/// The tables of a scene that its lights refer to by ids.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightTables<'a> {
    pub profiles: &'a [Profile],
}

/// The place of a scene and the look-up of names, with which its lights are compiled.
pub struct LightFind<'a> {
    /// The scene's origin in world space.
    pub origin: DVec3,
    /// The profile of a file.
    pub profile: &'a dyn Fn(&Spanned<String>) -> Result<ProfileId, Problem>,
}

fn no_profile(file: &Spanned<String>) -> Result<ProfileId, Problem> {
    Err(Problem::at(file.span(), "there are no files of profiles here"))
}

impl LightFind<'_> {
    /// That of lights which refer to nothing.
    pub fn nothing(origin: DVec3) -> Self {
        Self {
            origin,
            profile: &no_profile,
        }
    }
}
