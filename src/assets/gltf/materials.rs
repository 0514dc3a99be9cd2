//! Materials, textures and images.

use std::{collections::HashMap, path::Path};

use ::gltf::json::{
    texture::{Info, MagFilter, Sampler, WrappingMode},
    validation::Checked,
};

use super::{
    container::{self, Location},
    document::{Document, get},
    error::GltfProblem,
};
use crate::{
    assets::model::{ImageSource, Model, ModelMaterial, ModelTexture},
    math::Rgb,
    texture::image::{TextureFilter, Wrap},
};

/// The materials and images of the document that are used, each once.
#[derive(Default)]
pub(super) struct ModelMaterials {
    materials: HashMap<Option<usize>, usize>,
    images: HashMap<usize, usize>,
}

/// The texture that gives a material its base colour.
fn base_texture<'a>(document: &'a Document<'_>, material: Option<usize>) -> Result<Option<&'a Info>, GltfProblem> {
    let Some(index) = material else { return Ok(None) };
    let material = get(&document.root.materials, index, "material")?;
    Ok(material.pbr_metallic_roughness.base_color_texture.as_ref())
}

/// The set of texture coordinates that a material reads.
pub(super) fn uv_set(document: &Document<'_>, material: Option<usize>) -> Result<u32, GltfProblem> {
    Ok(base_texture(document, material)?.map_or(0, |t| t.tex_coord))
}

impl ModelMaterials {
    /// Puts a material into `model`; returns its number there. Without a material a surface is white.
    pub fn place(
        &mut self,
        document: &Document<'_>,
        material: Option<usize>,
        path: &Path,
        model: &mut Model,
    ) -> Result<usize, GltfProblem> {
        if let Some(known) = self.materials.get(&material) {
            return Ok(*known);
        }
        let mut made = ModelMaterial::default();
        if let Some(index) = material {
            let given = get(&document.root.materials, index, "material")?;
            let [r, g, b, _] = given.pbr_metallic_roughness.base_color_factor.0;
            made.name = given.name.clone().unwrap_or_default();
            made.base_color = Rgb::from_array([r, g, b].map(|v| if v.is_finite() { v.max(0.0) } else { 1.0 }));
        }
        if let Some(info) = base_texture(document, material)? {
            made.base_texture = self.texture(document, info.index.value(), path, model)?;
        }
        model.materials.push(made);
        let at = model.materials.len() - 1;
        self.materials.insert(material, at);
        Ok(at)
    }

    fn texture(
        &mut self,
        document: &Document<'_>,
        index: usize,
        path: &Path,
        model: &mut Model,
    ) -> Result<Option<usize>, GltfProblem> {
        let texture = get(&document.root.textures, index, "texture")?;
        let source = texture.source.value();
        if source == u32::MAX as usize {
            tracing::warn!("texture {index} has no image that can be read: {}", path.display());
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
                "texture {index} has an unknown wrapping mode"
            ))),
        };
        let filter = match sampler.mag_filter {
            Some(Checked::Valid(MagFilter::Nearest)) => TextureFilter::Nearest,
            _ => TextureFilter::Trilinear,
        };
        let image = match self.images.get(&source) {
            Some(known) => *known,
            None => {
                model.images.push(image(document, source, path)?);
                self.images.insert(source, model.images.len() - 1);
                model.images.len() - 1
            }
        };
        let wrap = [wrap(sampler.wrap_s)?, wrap(sampler.wrap_t)?];
        model.textures.push(ModelTexture { image, filter, wrap });
        Ok(Some(model.textures.len() - 1))
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
