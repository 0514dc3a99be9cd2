//! Materials of OBJ files: MTL with its extension for physically based surfaces.
//!
//! A material with only `Kd` is matte. `Ks` adds a dielectric reflection of that tint with the roughness of `Ns`; with `illum` 3 or
//! 8, or 5 and no `Ni` above 1, it is a mirror's. `illum` 4, 6, 7 and 9 make transparent materials glass. The names of
//! materials are compared as bytes.

mod options;
mod paths;
mod statements;
mod surface;
#[cfg(test)]
mod tests;
mod textures;

use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
};

use super::{
    error::ObjError,
    lines::{self, decode},
};
use crate::{
    assets::{
        Files,
        files::is_refused,
        model::{Model, ModelMaterial},
    },
    value::one_line,
    warnings::WarningKind,
};
use statements::{Number, Slot, Statements};
use surface::Reader;
use textures::{Images, Textures};

/// The materials of all libraries of a file, read once each.
pub(super) struct Library<'a> {
    files: &'a Files,
    /// By name, with the library's folder. Of two with the same name the later one counts.
    materials: HashMap<Vec<u8>, (Statements, PathBuf)>,
    images: Images,
}

/// The use of a material by meshes of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct MaterialUse<'a> {
    pub name: Option<&'a [u8]>,
    /// Whether the meshes have vertex colours.
    pub has_colors: bool,
}

impl<'a> Library<'a> {
    /// Reads the libraries of the `mtllib` lines. A missing library is a warning, and its faces are grey.
    ///
    /// # Errors
    /// A library is outside of the model's folder, or no regular file.
    pub fn load(obj: &Path, lines: &[Vec<u8>], files: &'a Files) -> Result<Self, ObjError> {
        let mut library = Self {
            files,
            materials: HashMap::new(),
            images: Images::new(),
        };
        let folder = obj.parent().unwrap_or(Path::new(""));
        let mut seen = HashSet::new();
        for path in lines.iter().flat_map(|line| paths::libraries(folder, line)) {
            if seen.insert(path.clone()) {
                paths::check_inside(files, obj, &path)?;
                library.add(obj, &path)?;
            }
        }
        library.check_transparency(obj);
        Ok(library)
    }

    /// Reads `Tr 1` as opaque where it is the only word on opacity and would hide the whole of a textured model: programs of
    /// photogrammetry mean the opacity by `Tr`.
    fn check_transparency(&mut self, obj: &Path) {
        let all = || self.materials.values().map(|(material, _)| material);
        let is_hidden =
            |m: &Statements| m.number(Number::D).is_none() && m.number(Number::Tr).is_some_and(|tr| tr >= 1.0);
        if !all().all(is_hidden) || !all().any(|m| m.map(Slot::Kd).is_some()) {
            return;
        }
        let obj = obj.display();
        let text = format!(
            "{obj}: `Tr 1` of all materials would hide the whole model, and is read as opaque; `d 0` makes it transparent"
        );
        self.files.warnings().add_topic(WarningKind::STATEMENT, "Tr", obj, text);
        for (material, _) in self.materials.values_mut() {
            material.forget(Number::Tr);
        }
    }

    fn add(&mut self, obj: &Path, path: &Path) -> Result<(), ObjError> {
        let (obj, shown) = (obj.display(), path.display());
        let bytes = match self.files.read(path) {
            Ok(bytes) => bytes,
            Err(source) if is_refused(&source) => {
                let path = path.to_owned();
                return Err(ObjError::Read { source, path });
            }
            Err(e) => {
                let text = format!("{obj}: cannot read the material library, its surfaces are gray: {e}: {shown}");
                self.files
                    .warnings()
                    .add_topic(WarningKind::MISSING_FILE, "library", shown, text);
                return Ok(());
            }
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        let read = statements::read(&decode(&bytes), path, self.files.warnings()).into_iter();
        self.materials
            .extend(read.map(|(name, material)| (name, (material, folder.to_owned()))));
        Ok(())
    }

    /// Adds a material and its images to `model`; returns the material's index.
    ///
    /// # Errors
    /// An image is outside of the model's folder.
    pub fn place(&mut self, wanted: MaterialUse<'_>, obj: &Path, model: &mut Model) -> Result<usize, ObjError> {
        let found = wanted.name.and_then(|name| self.materials.get(name));
        let name = wanted.name.map(lines::name).unwrap_or_default();
        if wanted.name.is_some() && found.is_none() && !self.materials.is_empty() {
            let (shown, obj) = (one_line(&name, 80), obj.display());
            let text = format!("{obj}: there is no material '{shown}', its surfaces are gray");
            self.files.warnings().add(WarningKind::MISSING_MATERIAL, shown, text);
        }
        let unknown = (Statements::default(), PathBuf::new());
        let (material, folder) = found.unwrap_or(&unknown);
        let mut reader = Reader {
            material,
            textures: Textures {
                files: self.files,
                obj,
                folder,
                images: &mut self.images,
                model,
            },
        };
        let surface = reader.surface(wanted.has_colors)?;
        model.materials.push(ModelMaterial {
            name,
            surface,
            ..ModelMaterial::default()
        });
        Ok(model.materials.len() - 1)
    }
}
