//! Material variants: sets of materials for the meshes of a file, by name.
//!
//! Source: Khronos, "KHR_materials_variants".

use ::gltf::json::Value;

use super::{document::Document, error::GltfProblem, json::index};
use crate::value::UnknownName;

/// The variants of a document, and the chosen one.
pub(super) struct Variants<'a> {
    names: Vec<&'a str>,
    /// The number of the chosen one; `None` for the default materials.
    chosen: Option<usize>,
}

impl<'a> Variants<'a> {
    /// Finds the variant of this name, if one is given.
    pub fn new(document: &'a Document<'_>, name: Option<&str>) -> Result<Self, GltfProblem> {
        let all = document.raw.pointer("/extensions/KHR_materials_variants/variants");
        let all = all.and_then(Value::as_array).into_iter().flatten();
        let names: Vec<&str> = all
            .map(|variant| variant.get("name").and_then(Value::as_str).unwrap_or_default())
            .collect();
        let find = |name: &str| {
            let unknown = || {
                let unknown = UnknownName::new("material variant", name, names.iter().copied());
                GltfProblem::UnknownName(if names.is_empty() {
                    unknown.with_fallback(Some("the model has none".to_owned()))
                } else {
                    unknown
                })
            };
            names.iter().position(|known| *known == name).ok_or_else(unknown)
        };
        let chosen = name.map(find).transpose()?;
        Ok(Self { names, chosen })
    }

    pub fn names(&self) -> Vec<String> {
        self.names.iter().map(|&name| name.to_owned()).collect()
    }

    /// The material of a primitive in the chosen variant, by the indices of mesh and primitive; `None` for its own.
    pub fn material(&self, document: &Document<'_>, [mesh, primitive]: [usize; 2]) -> Option<usize> {
        let chosen = self.chosen?;
        let path = format!("/meshes/{mesh}/primitives/{primitive}/extensions/KHR_materials_variants/mappings");
        let is_chosen = |mapping: &&Value| {
            let variants = mapping.get("variants").and_then(Value::as_array);
            variants
                .into_iter()
                .flatten()
                .any(|v| v.as_u64() == Some(chosen as u64))
        };
        let mut mappings = document.raw.pointer(&path)?.as_array()?.iter();
        index(mappings.find(is_chosen)?, "material")
    }
}
