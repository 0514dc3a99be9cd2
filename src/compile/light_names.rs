//! Names in lights of a scene: files of profiles, and textures.

use std::path::Path;

use super::textures::TextureNames;
use crate::{
    assets::{AssetError, Files, ies},
    describe::SceneDesc,
    light::{LightFind, Profile, ProfileId},
    math::DVec3,
    value::{Problem, Spanned, one_line},
    warnings::{WarningKind, Warnings},
};

/// The files and textures that the lights of a scene name.
pub(super) struct LightNames<'a> {
    /// The files of profiles, each once, in the order of their ids.
    files: Vec<String>,
    textures: TextureNames<'a>,
}

impl<'a> LightNames<'a> {
    pub fn new(desc: &'a SceneDesc) -> Self {
        let mut files: Vec<String> = Vec::new();
        for file in desc.lights.iter().filter_map(|entry| entry.light.ies()) {
            if !files.contains(file.name.get_ref()) {
                files.push(file.name.get_ref().clone());
            }
        }
        Self {
            files,
            textures: TextureNames::new(desc),
        }
    }

    /// Loads the files of profiles, whose names are relative to `folder`, or says what is wrong with each that is broken.
    pub fn load(&self, folder: &Path, files: &Files) -> Result<Vec<Profile>, Vec<AssetError>> {
        let (mut profiles, mut errors) = (Vec::new(), Vec::new());
        for name in &self.files {
            match ies::load(&folder.join(name), files) {
                Ok(profile) => profiles.push(profile),
                Err(error) => errors.push(error.into()),
            }
        }
        if errors.is_empty() { Ok(profiles) } else { Err(errors) }
    }

    /// Warns of lights whose files send all light to a side that does not shine; `profiles` are those of the files.
    pub fn warn_dark(&self, desc: &SceneDesc, profiles: &[Profile], warnings: &Warnings) {
        for (i, entry) in desc.lights.iter().enumerate() {
            let Some(file) = entry.light.ies() else { continue };
            let name = file.name.get_ref();
            let profile = self
                .files
                .iter()
                .position(|known| known == name)
                .map(|at| &profiles[at]);
            if profile.is_some_and(|profile| file.is_dark(profile)) {
                let (light, shown) = (format!("light {}", i + 1), one_line(name, 80));
                let text = format!(
                    "{light} is dark: all light of `ies = \"{shown}\"` goes backwards, which needs `two_sided = true`"
                );
                warnings.add_topic(WarningKind::UNUSED_SETTING, "ies", light, text);
            }
        }
    }

    /// Calls `with` to compile lights of a scene with this origin.
    pub fn find<T>(&self, origin: DVec3, with: impl FnOnce(&LightFind<'_>) -> T) -> T {
        let profile = |file: &Spanned<String>| {
            if file.get_ref().is_empty() {
                return Err(Problem::at(file.span(), "the name of the file is empty"));
            }
            let at = self.files.iter().position(|name| name == file.get_ref());
            let unknown = || Problem::at(file.span(), "the file of this light changes over time");
            at.map(|at| ProfileId(at as u32)).ok_or_else(unknown)
        };
        with(&LightFind {
            origin,
            profile: &profile,
            color: &|source| self.textures.color(source),
        })
    }
}
