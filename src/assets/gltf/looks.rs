//! Materials, textures, cameras and lights.

use std::{collections::HashMap, path::Path};

use ::gltf::json::{
    Value,
    camera::Camera,
    texture::{Info, MagFilter, Sampler, WrappingMode},
    validation::Checked,
};
use glam::DAffine3;

use super::{
    Problem,
    container::{self, Location},
    document::{Document, get},
};
use crate::{
    assets::model::{ImageSource, Model, ModelLight, ModelLightKind, ModelMaterial, ModelTexture, ModelView},
    math::Rgb,
    texture::image::{Filter, Wrap},
};

/// The materials and images of the document that are used, each once.
#[derive(Default)]
pub(super) struct Looks {
    materials: HashMap<Option<usize>, usize>,
    images: HashMap<usize, usize>,
}

/// The texture that gives a material its base colour.
fn base_texture<'a>(document: &'a Document<'_>, material: Option<usize>) -> Result<Option<&'a Info>, Problem> {
    let Some(index) = material else { return Ok(None) };
    let material = get(&document.root.materials, index, "material")?;
    Ok(material.pbr_metallic_roughness.base_color_texture.as_ref())
}

/// The set of texture coordinates that a material reads.
pub(super) fn uv_set(document: &Document<'_>, material: Option<usize>) -> Result<u32, Problem> {
    Ok(base_texture(document, material)?.map_or(0, |t| t.tex_coord))
}

impl Looks {
    /// Puts a material into `model`; returns its number there. Without a material a surface is white.
    pub fn place(
        &mut self,
        document: &Document<'_>,
        material: Option<usize>,
        path: &Path,
        model: &mut Model,
    ) -> Result<usize, Problem> {
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
    ) -> Result<Option<usize>, Problem> {
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
            Checked::Invalid => Err(Problem::broken(format!("texture {index} has an unknown wrapping mode"))),
        };
        let filter = match sampler.mag_filter {
            Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
            _ => Filter::Trilinear,
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

fn image(document: &Document<'_>, index: usize, path: &Path) -> Result<ImageSource, Problem> {
    let image = get(&document.root.images, index, "image")?;
    let name = || path.with_file_name(format!("{} (image {index})", file_name(path)));
    let embedded = |bytes: Vec<u8>| ImageSource::Bytes {
        name: name(),
        bytes: bytes.into(),
    };
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => Ok(match container::locate(document.folder, uri)? {
            Location::Here(bytes) => embedded(bytes),
            Location::File(file) => ImageSource::File(file),
        }),
        (None, Some(view)) => {
            let (bytes, _) = document.view(view.value())?;
            document.spend(bytes.len() as u64)?;
            Ok(embedded(bytes.to_vec()))
        }
        (None, None) => Err(Problem::broken(format!(
            "image {index} has neither a uri nor a buffer view"
        ))),
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// What a camera sees, `None` where it makes no sense.
pub(super) fn view(camera: &Camera) -> Option<ModelView> {
    let view = match (&camera.perspective, &camera.orthographic) {
        (Some(p), _) => ModelView::Perspective { fov: p.yfov.into() },
        (None, Some(o)) => ModelView::Orthographic {
            height: 2.0 * f64::from(o.ymag).abs(),
        },
        (None, None) => return None,
    };
    let sound = match view {
        ModelView::Perspective { fov } => fov > 0.0 && fov < std::f64::consts::PI,
        ModelView::Orthographic { height } => height > 0.0 && height.is_finite(),
    };
    sound.then_some(view)
}

/// The light of KHR_lights_punctual that a node carries.
pub(super) fn light(document: &Document<'_>, node: usize, place: DAffine3) -> Result<Option<ModelLight>, Problem> {
    const NAME: &str = "KHR_lights_punctual";
    fn extension(value: &Value) -> Option<&Value> {
        value.get("extensions").and_then(|e| e.get(NAME))
    }
    let carried = document.raw.get("nodes").and_then(|n| n.get(node)).and_then(extension);
    let Some(index) = carried.and_then(|e| e.get("light").and_then(Value::as_u64)) else {
        return Ok(None);
    };
    let lights = extension(&document.raw).and_then(|e| e.get("lights").and_then(Value::as_array));
    let lights = lights.map_or(&[][..], Vec::as_slice);
    let light = get(lights, usize::try_from(index).unwrap_or(usize::MAX), "light")?;
    let number = |from: &Value, key: &str, default: f64| from.get(key).and_then(Value::as_f64).unwrap_or(default);
    let intensity = number(light, "intensity", 1.0).max(0.0) as f32;
    let channel = |i: usize| light.get("color").and_then(|c| c.get(i)).and_then(Value::as_f64);
    let color = [0, 1, 2].map(|i| channel(i).unwrap_or(1.0).max(0.0) as f32 * intensity);
    let kind = match light.get("type").and_then(Value::as_str) {
        Some("point") => ModelLightKind::Point,
        Some("directional") => ModelLightKind::Sun,
        Some("spot") => {
            let spot = light.get("spot").unwrap_or(&Value::Null);
            let outer = number(spot, "outerConeAngle", std::f64::consts::FRAC_PI_4);
            let outer = outer.clamp(1e-4, std::f64::consts::FRAC_PI_2);
            let inner = number(spot, "innerConeAngle", 0.0).clamp(0.0, outer);
            ModelLightKind::Spot { inner, outer }
        }
        other => {
            return Err(Problem::broken(format!(
                "light {index} is of an unknown type: {}",
                other.unwrap_or("none")
            )));
        }
    };
    if !color.iter().all(|c| c.is_finite()) {
        return Err(Problem::broken(format!("light {index} is infinitely bright")));
    }
    Ok(Some(ModelLight {
        model_from_light: place,
        strength: Rgb::from_array(color),
        kind,
    }))
}
