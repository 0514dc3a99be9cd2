//! The textures and images of materials.

use std::{
    collections::HashMap,
    fs,
    path::{Path, PathBuf},
};

use super::{
    options::Map,
    paths::{check_inside, locate},
};
use crate::{
    assets::{
        Files, image,
        model::{ImageSource, Model, ModelTexture, Treatment},
        obj::ObjError,
    },
    texture::{TextureId, bitmap::ColorSpace},
    warnings::WarningKind,
};

/// The images of a model, by their files; `None` for missing ones.
pub(super) type Images = HashMap<PathBuf, Option<usize>>;

/// Adds textures to a model.
pub(super) struct Textures<'a, 'b> {
    pub files: &'b Files,
    /// The model's file, and the folder of its library.
    pub obj: &'a Path,
    pub folder: &'a Path,
    pub images: &'a mut Images,
    pub model: &'a mut Model,
}

impl Textures<'_, '_> {
    pub fn report(&mut self, name: &str, used_by: &'static str, treatment: Treatment) {
        self.model.add_feature(name, used_by, treatment);
    }

    /// Returns the image of a texture; `None` if it is missing, with a warning once for each file.
    fn image(&mut self, map: &Map) -> Result<Option<usize>, ObjError> {
        let file = locate(self.folder, &map.file);
        check_inside(self.files, self.obj, &file)?;
        if let Some(known) = self.images.get(&file) {
            return Ok(*known);
        }
        let found = match fs::metadata(&file) {
            Ok(_) if image::is_unknown(&file, self.files) => Err("the format of the image is unknown".to_owned()),
            found => found.map_err(|e| e.to_string()),
        };
        let image = match found {
            Ok(_) => {
                self.model.images.push(ImageSource::File(file.clone()));
                Some(self.model.images.len() - 1)
            }
            Err(e) => {
                let (obj, shown) = (self.obj.display(), file.display());
                let text = format!("{obj}: cannot read a texture, its surfaces are rendered without it: {e}: {shown}");
                self.files
                    .warnings()
                    .add_topic(WarningKind::MISSING_FILE, "texture", shown, text);
                None
            }
        };
        self.images.insert(file, image);
        Ok(image)
    }

    /// Returns the texture; `None` if its file is missing.
    ///
    /// # Errors
    /// The file is outside of the model's folder.
    pub fn place(&mut self, map: &Map, color_space: ColorSpace) -> Result<Option<TextureId>, ObjError> {
        let Some(image) = self.image(map)? else {
            return Ok(None);
        };
        for option in &map.unsupported {
            self.report(option, "texture", Treatment::Without(""));
        }
        if map.base != 0.0 {
            let how = Treatment::InPart("the base is left out, the gain is not");
            self.report("-mm", "texture", how);
        }
        self.model.textures.push(ModelTexture {
            color_space,
            wrap: [map.wrap; 2],
            transform: map.transform,
            ..ModelTexture::of_image(image)
        });
        Ok(Some(TextureId(self.model.textures.len() as u32 - 1)))
    }

    /// Whether the picture is a normal map.
    pub fn holds_normals(&mut self, map: &Map) -> Result<bool, ObjError> {
        let Some(image) = self.image(map)? else {
            return Ok(false);
        };
        let ImageSource::File(file) = &self.model.images[image] else {
            return Ok(false);
        };
        Ok(image::holds_normals(file, self.files))
    }

    /// Whether the picture has an alpha channel.
    pub fn has_alpha(&mut self, map: &Map) -> Result<bool, ObjError> {
        let Some(image) = self.image(map)? else {
            return Ok(false);
        };
        let ImageSource::File(file) = &self.model.images[image] else {
            return Ok(false);
        };
        Ok(image::has_alpha(file, self.files))
    }
}
