//! Objects to geometry.

use super::{load::Compiler, models::PlacedModel};
use crate::{describe::ObjectDesc, material::MaterialId, math::Transform, shape::ShapeDesc, value::Problem};

impl Compiler<'_> {
    /// Adds all objects to the scene; returns those whose geometry is in files.
    pub(super) fn objects(&mut self) -> Vec<PlacedModel> {
        let mut models = Vec::new();
        for (i, object) in self.desc.objects.iter().enumerate() {
            let material = self.material_of(object);
            let transform = self.transform_of(object);
            let name = name_of(object, i);
            if let ShapeDesc::Mesh(mesh) = object.shape.get_ref() {
                let (Some(material), Some(transform)) = (material, transform) else {
                    continue;
                };
                let file = mesh.file.get_ref();
                let first = material.unwrap_or(MaterialId(0));
                models.push(PlacedModel {
                    object: self.scene.object(&name, Some(file), first),
                    file: self.desc.folder().join(file),
                    material,
                    transform,
                });
                continue;
            }
            let shape = self.record(object.shape.get_ref().compile().map_err(|problem| {
                // A kind that has no better place for its problem means the whole shape.
                let span = problem.span.clone().or_else(|| Some(object.shape.span()));
                Problem { span, ..problem }
            }));
            let (Some(Some(material)), Some(shape), Some(transform)) = (material, shape, transform) else {
                continue;
            };
            self.scene.shape(&name, shape, transform, material);
        }
        models
    }

    /// The object's material, `Some(None)` where a mesh has its own.
    fn material_of(&mut self, object: &ObjectDesc) -> Option<Option<MaterialId>> {
        let found = match (&object.material, object.shape.get_ref()) {
            (Some(name), _) => self.material_id(name).map(Some),
            (None, ShapeDesc::Mesh(_)) => Ok(None),
            (None, _) => {
                let message = "an object of this shape needs a `material`";
                Err(Problem::at(object.shape.span(), message).with_help("only a `shape.mesh` brings its own"))
            }
        };
        self.record(found)
    }

    /// `Some(None)` where there is none, or one that changes nothing.
    fn transform_of(&mut self, object: &ObjectDesc) -> Option<Option<Transform>> {
        let Some(given) = &object.transform else {
            return Some(None);
        };
        let transform = self.record(given.get_ref().compile(given.span()))?;
        Some((!transform.is_identity()).then_some(transform))
    }
}

fn name_of(object: &ObjectDesc, index: usize) -> String {
    let name = object.name.as_ref().map(|n| n.get_ref().clone());
    name.unwrap_or_else(|| format!("object {}", index + 1))
}
