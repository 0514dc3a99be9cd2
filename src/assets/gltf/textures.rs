//! Textures and images.

use std::{
    collections::{HashMap, HashSet},
    path::Path,
};

use ::gltf::json::{
    Value,
    texture::{MagFilter, Sampler, WrappingMode},
    validation::Checked,
};

use super::{
    container::{self, Location},
    document::{Document, get},
    error::GltfProblem,
    json::{index, number, numbers},
};
use crate::{
    assets::{
        model::{ImageSource, Model, ModelTexture, Treatment, UvSet},
        motion::TextureMotion,
    },
    math::Vec2,
    texture::{
        StTransform, TextureId,
        bitmap::ColorSpace,
        image::{TextureFilter, Wrap},
    },
};

/// The images of the document that are used, each once.
#[derive(Default)]
pub(super) struct ModelImages {
    images: HashMap<usize, usize>,
    /// The textures that only one reference has.
    own: HashSet<usize>,
}

/// The sets of texture coordinates that a material reads, by their numbers in the document.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct UvSets {
    pub first: u32,
    pub second: Option<u32>,
}

impl UvSets {
    /// The texture coordinates of the mesh that contain this set; `None` if the mesh does not have it.
    pub fn of(self, number: u32) -> Option<UvSet> {
        match number {
            set if set == self.first => Some(UvSet::First),
            set if Some(set) == self.second => Some(UvSet::Second),
            _ => None,
        }
    }
}

/// The number of the set that a texture reference reads.
pub(super) fn uv_set(info: &Value) -> u32 {
    let transform = info.pointer("/extensions/KHR_texture_transform/texCoord");
    let set = transform.or_else(|| info.get("texCoord")).and_then(Value::as_u64);
    set.and_then(|set| u32::try_from(set).ok()).unwrap_or(0)
}

impl ModelImages {
    /// The numbers of the images in the document.
    pub fn used(&self) -> Vec<usize> {
        self.images.keys().copied().collect()
    }

    /// Adds the texture that a material refers to to `model`; `None` if it cannot be rendered. `is_own` tells that no other
    /// reference is to have the same one.
    pub fn place(
        &mut self,
        document: &Document<'_>,
        (info, is_own): (&Value, bool),
        sets: UvSets,
        color_space: ColorSpace,
        path: &Path,
        model: &mut Model,
    ) -> Result<Option<TextureId>, GltfProblem> {
        let number = index(info, "index").ok_or_else(|| GltfProblem::broken("a texture reference has no index"))?;
        let texture = get(&document.root.textures, number, "texture")?;
        let raw = document.raw.pointer(&format!("/textures/{number}"));
        let webp = raw.and_then(|t| t.pointer("/extensions/EXT_texture_webp"));
        let source = match webp.and_then(|e| index(e, "source")) {
            Some(source) => source,
            None => texture.source.value(),
        };
        if source == u32::MAX as usize {
            model.add_feature("images of unknown formats", "texture", Treatment::Without(""));
            return Ok(None);
        }
        let default = Sampler::default();
        let sampler = match texture.sampler {
            Some(sampler) => get(&document.root.samplers, sampler.value(), "sampler")?,
            None => &default,
        };
        let wrap = |mode: Checked<WrappingMode>| match mode {
            Checked::Valid(WrappingMode::ClampToEdge) => Ok(Wrap::Clamp),
            Checked::Valid(WrappingMode::MirroredRepeat) => Ok(Wrap::Mirror),
            Checked::Valid(WrappingMode::Repeat) => Ok(Wrap::Repeat),
            Checked::Invalid => Err(GltfProblem::broken(format!(
                "texture {number} has an unknown wrapping mode"
            ))),
        };
        if sampler.min_filter.is_some() {
            let why = Treatment::Unneeded("each pixel shows the mean of the texels that it covers");
            model.add_feature("minFilter", "texture", why);
        }
        let filter = match sampler.mag_filter {
            Some(Checked::Valid(MagFilter::Nearest)) => TextureFilter::Nearest,
            _ => TextureFilter::Trilinear,
        };
        let made = ModelTexture {
            image: self.image(document, source, path, model)?,
            color_space,
            filter,
            wrap: [wrap(sampler.wrap_s)?, wrap(sampler.wrap_t)?],
            transform: transform(info),
            uv_set: sets.of(uv_set(info)).unwrap_or_default(),
        };
        let is_it = |(at, known): (usize, &ModelTexture)| *known == made && !self.own.contains(&at);
        let known = model.textures.iter().enumerate().position(is_it);
        let at = known.filter(|_| !is_own).unwrap_or_else(|| {
            model.textures.push(made);
            model.textures.len() - 1
        });
        if is_own {
            self.own.insert(at);
        }
        Ok(Some(TextureId(at as u32)))
    }

    fn image(
        &mut self,
        document: &Document<'_>,
        source: usize,
        path: &Path,
        model: &mut Model,
    ) -> Result<usize, GltfProblem> {
        if let Some(known) = self.images.get(&source) {
            return Ok(*known);
        }
        model.images.push(image(document, source, path)?);
        self.images.insert(source, model.images.len() - 1);
        Ok(model.images.len() - 1)
    }
}

/// The transform of KHR_texture_transform, from (u, v) with v down to (s, t) with t up.
fn transform(info: &Value) -> StTransform {
    match info.pointer("/extensions/KHR_texture_transform") {
        Some(_) => motion(info, TextureId(0)).transform(),
        None => StTransform::IDENTITY,
    }
}

/// The motion of the texture of a reference, at rest.
pub(super) fn motion(info: &Value, texture: TextureId) -> TextureMotion {
    let given = info
        .pointer("/extensions/KHR_texture_transform")
        .unwrap_or(&Value::Null);
    let pair = |key: &str, default: f32| Vec2::from_array(numbers(given, key, [default; 2]));
    TextureMotion {
        texture: texture.0 as usize,
        offset: pair("offset", 0.0),
        rotation: number(given, "rotation", 0.0),
        scale: pair("scale", 1.0),
    }
}

fn image(document: &Document<'_>, index: usize, path: &Path) -> Result<ImageSource, GltfProblem> {
    let image = get(&document.root.images, index, "image")?;
    let name = || path.with_file_name(format!("{} (image {index})", file_name(path)));
    let embedded = |bytes: Vec<u8>| ImageSource::Bytes {
        name: name(),
        bytes: bytes.into(),
    };
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => Ok(match container::locate(document.folder, uri, document.files)? {
            Location::Here(bytes) => embedded(bytes),
            Location::File(file) => ImageSource::File(file),
        }),
        (None, Some(view)) => {
            let (bytes, _) = document.view(view.value())?;
            document.reserve(bytes.len() as u64)?;
            Ok(embedded(bytes.to_vec()))
        }
        (None, None) => Err(GltfProblem::broken(format!(
            "image {index} has neither a uri nor a buffer view"
        ))),
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
