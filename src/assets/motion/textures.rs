//! Transforms of textures that animations change, by KHR_animation_pointer.
//!
//! Source: Khronos, "KHR_texture_transform" and "KHR_animation_pointer".

use crate::{
    math::{Vec2, keys::Keys},
    texture::StTransform,
};

/// The keys of the references of a material to textures that are shown; no two of them are alike.
const TEXTURES: [&str; 19] = [
    "baseColorTexture",
    "metallicRoughnessTexture",
    "normalTexture",
    "emissiveTexture",
    "clearcoatTexture",
    "clearcoatRoughnessTexture",
    "clearcoatNormalTexture",
    "sheenColorTexture",
    "sheenRoughnessTexture",
    "specularTexture",
    "specularColorTexture",
    "iridescenceTexture",
    "iridescenceThicknessTexture",
    "anisotropyTexture",
    "transmissionTexture",
    "diffuseTransmissionTexture",
    "diffuseTransmissionColorTexture",
    "diffuseTexture",
    "specularGlossinessTexture",
];

/// The transform of a texture, as KHR_texture_transform has it.
#[derive(Clone, Copy, Debug)]
pub struct TextureMotion {
    /// An index into [`Model::textures`](crate::assets::model::Model::textures), whose texture no other material has.
    pub texture: usize,
    pub offset: Vec2,
    /// In radians.
    pub rotation: f32,
    pub scale: Vec2,
}

/// A parameter of the transform of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureProperty {
    Offset,
    Rotation,
    Scale,
}

impl TextureProperty {
    /// The property at this path in the reference of a material to a texture, and the number of numbers in a key.
    fn of_path(path: &str) -> Option<(Self, usize)> {
        match path.strip_prefix("extensions/KHR_texture_transform/")? {
            "offset" => Some((Self::Offset, 2)),
            "rotation" => Some((Self::Rotation, 1)),
            "scale" => Some((Self::Scale, 2)),
            _ => None,
        }
    }
}

/// The key of a texture reference in a material, the property of its transform, and the number of
/// numbers in a key of the animation.
pub fn texture_property(path: &str) -> Option<(&'static str, TextureProperty, usize)> {
    let at = path.rfind("/extensions/KHR_texture_transform/")?;
    let (reference, inner) = (&path[..at], &path[at + 1..]);
    let (property, width) = TextureProperty::of_path(inner)?;
    let own = reference.rsplit('/').next()?;
    let key = TEXTURES.into_iter().find(|key| *key == own)?;
    Some((key, property, width))
}

impl TextureMotion {
    pub(super) fn set(&mut self, property: TextureProperty, keys: &Keys, time: f32) {
        let pair = || Vec2::from_array(keys.array(time).map(|v| v as f32));
        match property {
            TextureProperty::Offset => self.offset = pair(),
            TextureProperty::Scale => self.scale = pair(),
            TextureProperty::Rotation => self.rotation = keys.array::<1>(time)[0] as f32,
        }
    }

    pub fn transform(&self) -> StTransform {
        StTransform::of_uv(self.offset, self.rotation, self.scale)
    }
}
