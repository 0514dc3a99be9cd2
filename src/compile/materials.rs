//! Materials of a scene file and of models.

use std::collections::HashMap;

use super::compiler::{Compiler, undefined};
use crate::{
    assets::model::{Model, ModelTexture, UvSet},
    describe::{MaterialEntry, SceneDesc},
    material::{Material, MaterialDesc, matte::Matte, principled::Principled},
    math::ColorConversion,
    scene::SceneBuilder,
    texture::{BitmapId, Color, Mapping, Pattern, Texture, TextureId, image::ImagePattern},
    value::{ColorSource, Problem, Spanned},
};

impl Compiler<'_> {
    pub(super) fn materials(&mut self) {
        let names = TextureNames::new(self.desc);
        for entry in &self.desc.materials {
            if let Some(material) = self.record(names.material(entry)) {
                self.scene.named_material(entry.name.get_ref(), material);
            }
        }
    }
}

/// The textures of a scene file by name.
pub(super) struct TextureNames<'a> {
    desc: &'a SceneDesc,
    ids: HashMap<&'a str, u32>,
}

impl<'a> TextureNames<'a> {
    pub fn new(desc: &'a SceneDesc) -> Self {
        let names = desc.textures.iter().map(|t| t.name.get_ref().as_str());
        Self {
            desc,
            ids: names.zip(0..).collect(),
        }
    }

    /// Compiles a material of the scene file.
    pub fn material(&self, entry: &MaterialEntry) -> Result<Material, Problem> {
        let texture = |name: &str, source: &Spanned<ColorSource>| match self.ids.get(name) {
            Some(id) => Ok(TextureId(*id)),
            None => {
                let known = self.desc.textures.iter().map(|t| &t.name);
                Err(undefined("texture", name, source.span(), known))
            }
        };
        compile(&entry.material, &texture).map_err(|problem| {
            // A problem without a span belongs to the whole material.
            let span = problem.span.clone().or_else(|| Some(entry.name.span()));
            Problem { span, ..problem }
        })
    }
}

/// Finds a texture by its name.
type FindTexture<'a> = dyn Fn(&str, &Spanned<ColorSource>) -> Result<TextureId, Problem> + 'a;

fn compile(desc: &MaterialDesc, texture: &FindTexture<'_>) -> Result<Material, Problem> {
    desc.compile(&|source| {
        Ok(match source.get_ref() {
            ColorSource::Constant(color) => Color::Constant(*color),
            ColorSource::Texture(name) => Color::Texture(texture(name, source)?),
            ColorSource::Tinted { texture: name, tint } => Color::Tinted(texture(name, source)?, *tint),
        })
    })
}

/// Adds the materials of a model with their textures; `bitmaps` are those of its textures.
pub(super) fn add_model_materials(scene: &mut SceneBuilder, model: &Model, bitmaps: &[BitmapId]) {
    let first = TextureId(scene.texture_count() as u32);
    for (texture, bitmap) in model.textures.iter().zip(bitmaps) {
        scene.texture(texture_of(texture, *bitmap));
    }
    for material in &model.materials {
        scene.named_material(&material.name, model_material(&material.surface, first));
    }
}

/// A material of a model whose first texture has this id in the scene.
pub(super) fn model_material(surface: &Principled, first: TextureId) -> Material {
    let surface = surface.map_textures(|id| TextureId(first.0 + id.0));
    // Faster, with the same picture.
    match surface.matte_color() {
        Some(albedo) => Material::Matte(Matte::smooth(albedo)),
        None => Material::Principled(surface),
    }
}

fn texture_of(texture: &ModelTexture, bitmap: BitmapId) -> Texture {
    Texture {
        mapping: match texture.uv_set {
            UvSet::First => Mapping::Uv,
            UvSet::Second => Mapping::SecondUv,
        },
        transform: texture.transform,
        pattern: Pattern::Image(ImagePattern {
            bitmap,
            filter: texture.filter,
            wrap: texture.wrap,
        }),
        colors: ColorConversion::default(),
    }
}
