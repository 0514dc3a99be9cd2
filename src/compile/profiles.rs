//! The profiles of lights, by the files that a scene names.

use std::path::Path;

use crate::{
    assets::{AssetError, Files, ies},
    describe::SceneDesc,
    light::{LightFind, Profile, ProfileId},
    math::DVec3,
    value::{Problem, Spanned},
};

/// The files of the profiles of a scene, each once, in the order of their ids.
#[derive(Clone, Debug, Default)]
pub(super) struct ProfileFiles {
    names: Vec<String>,
}

impl ProfileFiles {
    pub fn new(desc: &SceneDesc) -> Self {
        let mut names: Vec<String> = Vec::new();
        for file in desc.lights.iter().filter_map(|entry| entry.light.ies()) {
            if !names.contains(file.get_ref()) {
                names.push(file.get_ref().clone());
            }
        }
        Self { names }
    }

    /// Loads the files, whose names are relative to `folder`, or says what is wrong with each that is broken.
    pub fn load(&self, folder: &Path, files: &Files) -> Result<Vec<Profile>, Vec<AssetError>> {
        let (mut profiles, mut errors) = (Vec::new(), Vec::new());
        for name in &self.names {
            match ies::load(&folder.join(name), files) {
                Ok(profile) => profiles.push(profile),
                Err(error) => errors.push(error.into()),
            }
        }
        if errors.is_empty() { Ok(profiles) } else { Err(errors) }
    }

    /// Calls `with` to compile lights of a scene with this origin.
    pub fn find<T>(&self, origin: DVec3, with: impl FnOnce(&LightFind<'_>) -> T) -> T {
        let profile = |file: &Spanned<String>| {
            let at = self.names.iter().position(|name| name == file.get_ref());
            let unknown = || Problem::at(file.span(), "the file of this light changes over time");
            at.map(|at| ProfileId(at as u32)).ok_or_else(unknown)
        };
        with(&LightFind {
            origin,
            profile: &profile,
        })
    }
}
