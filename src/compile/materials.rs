//! Materials of a scene file and of models: both go through a [`MaterialDesc`].

use std::collections::HashMap;

use super::compiler::{Compiler, undefined};
use crate::{
    assets::model::{Model, ModelMaterial, ModelTexture},
    material::{Material, MaterialDesc, matte::MatteDesc},
    scene::SceneBuilder,
    texture::{BitmapId, Color, Mapping, Pattern, StTransform, Texture, TextureId, image::ImagePattern},
    value::{ColorSource, Problem, Spanned},
};

impl Compiler<'_> {
    pub(super) fn materials(&mut self) {
        let desc = self.desc;
        let names: HashMap<&str, u32> = desc
            .textures
            .iter()
            .zip(0..)
            .map(|(t, i)| (t.name.get_ref().as_str(), i))
            .collect();
        let texture = |name: &str, source: &Spanned<ColorSource>| match names.get(name) {
            Some(id) => Ok(TextureId(*id)),
            None => Err(undefined(
                "texture",
                name,
                source.span(),
                desc.textures.iter().map(|t| &t.name),
            )),
        };
        for entry in &desc.materials {
            let name = &entry.name;
            let material = compile(&entry.material, &texture).map_err(|problem| {
                // A kind that has no better place for its problem means the whole material.
                let span = problem.span.clone().or_else(|| Some(name.span()));
                Problem { span, ..problem }
            });
            if let Some(material) = self.record(material) {
                self.scene.named_material(name.get_ref(), material);
            }
        }
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

/// Adds the materials of a model with their textures. `first_image` is the number of the model's first image.
pub(super) fn add_model_materials(scene: &mut SceneBuilder, model: &Model, first_image: usize) -> Result<(), Problem> {
    let textures: Vec<TextureId> = model
        .textures
        .iter()
        .map(|texture| scene.texture(texture_of(texture, first_image)))
        .collect();
    let find = |name: &str, source: &Spanned<ColorSource>| {
        let known = name.parse().ok().and_then(|i: usize| textures.get(i).copied());
        known.ok_or_else(|| Problem::at(source.span(), format!("the model has no texture {name}")))
    };
    for material in &model.materials {
        let compiled = compile(&describe(material), &find)?;
        scene.named_material(&material.name, compiled);
    }
    Ok(())
}

/// The description of a model's material, whose textures are called by their numbers in the model. This is the one
/// place that decides which kind of material a model's surface becomes.
fn describe(material: &ModelMaterial) -> MaterialDesc {
    let albedo = match material.base_texture {
        None => ColorSource::Constant(material.base_color),
        Some(texture) => ColorSource::Tinted {
            texture: texture.to_string(),
            tint: material.base_color,
        },
    };
    MaterialDesc::Matte(MatteDesc {
        albedo: Spanned::new(0..0, albedo),
        roughness: None,
    })
}

fn texture_of(texture: &ModelTexture, first_image: usize) -> Texture {
    Texture {
        mapping: Mapping::Uv,
        transform: StTransform::IDENTITY,
        pattern: Pattern::Image(ImagePattern {
            bitmap: BitmapId((first_image + texture.image) as u32),
            filter: texture.filter,
            wrap: texture.wrap,
        }),
    }
}
