//! Materials of a scene file and of models.

use std::collections::HashMap;

use super::{
    compiler::{Compiler, undefined},
    nesting::Nesting,
    textures::TextureNames,
};
use crate::{
    assets::model::{Model, ModelTexture, UvSet},
    describe::{MaterialEntry, SceneDesc},
    material::{Find, Material, MaterialId, NormalMap, matte::Matte, principled::Principled},
    scene::{BackFaces, MaterialBackFaces, SceneBuilder, two_sided_reason},
    texture::{BitmapId, Mapping, Pattern, Texture, TextureId, Textures, image::ImagePattern},
    value::{Problem, Spanned},
    warnings::{WarningKind, Warnings},
};

impl Compiler<'_> {
    pub(super) fn materials(&mut self) {
        let names = MaterialNames::new(self.desc);
        for entry in &self.desc.materials {
            let Some(material) = self.record(names.material(entry)) else {
                continue;
            };
            let map = self.record(names.normal_map(entry, &material)).flatten();
            let id = self.scene.named_material(entry.name.get_ref(), material);
            if let Some(map) = map {
                self.scene.set_normal_map(id, map);
            }
            if let Some(backs) = &entry.back_faces {
                let (own, in_file) = (*backs.get_ref(), *backs.get_ref());
                self.scene
                    .set_material_back_faces(id, MaterialBackFaces { own, in_file });
            }
        }
        self.problems.extend(names.tangled());
    }
}

/// The materials of a scene file by name.
pub(super) struct MaterialNames<'a> {
    desc: &'a SceneDesc,
    materials: HashMap<&'a str, u32>,
    textures: TextureNames<'a>,
}

impl<'a> MaterialNames<'a> {
    pub fn new(desc: &'a SceneDesc) -> Self {
        let materials = desc.materials.iter().map(|m| m.name.get_ref().as_str());
        Self {
            desc,
            materials: materials.zip(0..).collect(),
            textures: TextureNames::new(desc),
        }
    }

    /// The problem of the first mixture that contains itself, or is made of too many others.
    pub fn tangled(&self) -> Option<Problem> {
        let entries = &self.desc.materials;
        let mut nesting = Nesting::new(entries.len(), |id: usize| {
            let mixed = entries[id].material.mixed().into_iter().flatten();
            mixed.filter_map(|name| self.materials.get(name.get_ref().as_str()).map(|id| *id as usize))
        });
        (0..entries.len()).find_map(|id| {
            let tangle = nesting.of(id).err()?;
            let message = tangle.message("material", |id| entries[id].name.get_ref());
            Some(Problem::at(entries[id].name.span(), message))
        })
    }

    /// Compiles a material of the scene file.
    pub fn material(&self, entry: &MaterialEntry) -> Result<Material, Problem> {
        let compiled = self.find(|find| entry.material.compile(find));
        let material = compiled.map_err(|problem| {
            // A problem without a span belongs to the whole material.
            let span = problem.span.clone().or_else(|| Some(entry.name.span()));
            Problem { span, ..problem }
        })?;
        match (&entry.back_faces, two_sided_reason(&material)) {
            (Some(backs), Some(reason)) if *backs.get_ref() != BackFaces::Shaded => {
                let message = format!("the material has no back: {reason}");
                Err(Problem::at(backs.span(), message))
            }
            _ => Ok(material),
        }
    }

    /// Compiles the normal map that a material of the scene file is given.
    pub fn normal_map(&self, entry: &MaterialEntry, material: &Material) -> Result<Option<NormalMap>, Problem> {
        let (span, map) = match (&entry.bump, &entry.normal) {
            (None, None) => return Ok(None),
            (Some(bump), None) => {
                let map = self.find(|find| bump.get_ref().compile(find))?;
                (bump.span(), map)
            }
            (None, Some(normal)) => {
                let map = self.find(|find| normal.get_ref().compile(find))?;
                (normal.span(), map)
            }
            (Some(_), Some(normal)) => {
                return Err(Problem::at(
                    normal.span(),
                    "a material has `bump` or `normal`, not both",
                ));
            }
        };
        if material.mixture().is_some() {
            let problem = Problem::at(span, "a mixture has no surface of its own");
            return Err(problem.with_help("give it to the materials that are mixed"));
        }
        if material.normal_map().is_some() {
            let kind = entry.material.name();
            return Err(Problem::at(span, format!("`{kind}` has a normal map already")));
        }
        Ok(Some(map))
    }

    /// Calls `with` to compile a part of a material.
    fn find<T>(&self, with: impl FnOnce(&Find<'_>) -> T) -> T {
        with(&Find {
            color: &|source| self.textures.color(source),
            directions: &|source| self.textures.directions(source),
            material: &|name| self.component(name),
        })
    }

    /// The material `name` as a part of a mixture.
    fn component(&self, name: &Spanned<String>) -> Result<MaterialId, Problem> {
        let Some(&id) = self.materials.get(name.get_ref().as_str()) else {
            let known = self.desc.materials.iter().map(|m| &m.name);
            return Err(undefined("material", name.get_ref(), name.span(), known));
        };
        let entry = &self.desc.materials[id as usize];
        let unmixable = if entry.back_faces.is_some() {
            Some("only the whole mixture may have `back_faces`")
        } else if entry.material.mixed().is_some() {
            // Its components are looked at where it is compiled itself.
            None
        } else {
            match self.material(entry) {
                Ok(material) => unmixable(&material),
                // It is told where it is.
                Err(_) => Some("it has an error of its own"),
            }
        };
        match unmixable {
            None => Ok(MaterialId(id)),
            Some(reason) => {
                let message = format!("`{}` cannot be mixed: {reason}", name.get_ref());
                Err(Problem::at(name.span(), message).with_help("mix opaque materials without light of their own"))
            }
        }
    }
}

/// The reason why a material cannot be a part of a mixture.
fn unmixable(material: &Material) -> Option<&'static str> {
    if material.emission().is_some() {
        Some("it emits light")
    } else if !material.is_opaque() {
        Some("it has an opacity")
    } else if material.medium().is_some() || material.may_transmit_straight() {
        Some("light passes it")
    } else {
        None
    }
}

/// Adds the materials of a model with their textures; `bitmaps` are those of its textures.
pub(super) fn add_model_materials(scene: &mut SceneBuilder, model: &Model, bitmaps: &[BitmapId]) {
    let first = TextureId(scene.texture_count() as u32);
    for (texture, bitmap) in model.textures.iter().zip(bitmaps) {
        scene.texture(texture_of(texture, *bitmap));
    }
    for material in &model.materials {
        let id = scene.named_material(&material.name, model_material(&material.surface, first));
        if material.is_one_sided {
            let (own, in_file) = (BackFaces::Shaded, BackFaces::Culled);
            scene.set_material_back_faces(id, MaterialBackFaces { own, in_file });
        }
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
    let mapping = match texture.uv_set {
        UvSet::First => Mapping::Uv,
        UvSet::Second => Mapping::SecondUv,
    };
    Texture {
        transform: texture.transform,
        ..Texture::new(
            mapping,
            Pattern::Image(ImagePattern {
                bitmap,
                filter: texture.filter,
                wrap: texture.wrap,
            }),
        )
    }
}

/// Warns of a material if it reflects more light than it receives.
pub(super) fn warn_of_gain(name: &str, material: &Material, textures: &Textures<'_>, warnings: &Warnings) {
    let max_reflectance = material.max_reflectance(textures);
    if max_reflectance > 1.0 {
        let text = format!("material `{name}` reflects more light than it receives (albedo {max_reflectance})");
        warnings.add(WarningKind::ENERGY_GAIN, name, text);
    }
}
