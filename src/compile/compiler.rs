//! The state of compilation.

use std::collections::HashMap;

use super::options::LoadOptions;
use crate::{
    assets::store::ImageRequest,
    describe::SceneDesc,
    material::MaterialId,
    math::{DVec3, Rgb},
    scene::{Background, SceneBuilder},
    value::{Problem, Spanned, UnknownName},
};

/// The state of compilation.
pub(super) struct Compiler<'a> {
    pub desc: &'a SceneDesc,
    /// The scene's origin in world space.
    pub origin: DVec3,
    pub options: &'a LoadOptions,
    pub scene: SceneBuilder,
    /// The images to load, once for each colour space, in the order of their [`BitmapId`](crate::texture::BitmapId)s.
    pub images: Vec<ImageRequest>,
    /// The numbers of materials by name.
    material_ids: HashMap<&'a str, u32>,
    pub problems: Vec<Problem>,
}

impl<'a> Compiler<'a> {
    pub fn new(desc: &'a SceneDesc, origin: DVec3, options: &'a LoadOptions) -> Self {
        let mut scene = SceneBuilder::new(Background::new(Rgb::BLACK));
        scene.set_origin(origin);
        let names = desc.materials.iter().map(|m| m.name.get_ref().as_str());
        Self {
            desc,
            origin,
            options,
            scene,
            images: Vec::new(),
            material_ids: names.zip(0..).collect(),
            problems: Vec::new(),
        }
    }

    /// Returns the compiled value, or records the problem.
    pub fn record<T>(&mut self, result: Result<T, Problem>) -> Option<T> {
        result.map_err(|problem| self.problems.push(problem)).ok()
    }

    pub fn material_id(&self, name: &Spanned<String>) -> Result<MaterialId, Problem> {
        match self.material_ids.get(name.get_ref().as_str()) {
            Some(&at) => Ok(MaterialId(at)),
            None => Err(undefined(
                "material",
                name.get_ref(),
                name.span(),
                self.desc.materials.iter().map(|m| &m.name),
            )),
        }
    }
}

pub(super) fn undefined<'a>(
    what: &str,
    name: &str,
    span: std::ops::Range<usize>,
    known: impl Iterator<Item = &'a Spanned<String>>,
) -> Problem {
    UnknownName::new(what, name, known.map(|n| n.get_ref().as_str()))
        .with_fallback(Some(format!("define it: [{what}.{name}]")))
        .at(span)
}
