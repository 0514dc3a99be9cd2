//! Objects to geometry.

use super::{Compiler, meshes::PlacedModel};
use crate::{
    accel::Geometry,
    describe::ObjectDesc,
    material::MaterialId,
    math::Transform,
    scene::{Object, ObjectId},
    shape::ShapeDesc,
    value::Problem,
};

/// The objects of a scene and what a ray can meet of them.
#[derive(Default)]
pub(super) struct Objects {
    pub geometry: Geometry,
    pub objects: Vec<Object>,
    /// Object of each of the geometry's shapes.
    pub shape_objects: Vec<ObjectId>,
    /// Objects whose geometry is in files.
    pub meshes: Vec<PlacedModel>,
}

impl Compiler<'_> {
    pub(super) fn objects(&mut self) -> Objects {
        let mut out = Objects::default();
        for (i, object) in self.desc.objects.iter().enumerate() {
            let material = self.material_of(object);
            let transform = self.transform_of(object);
            let id = ObjectId(out.objects.len() as u32);
            if let ShapeDesc::Mesh(mesh) = object.shape.get_ref() {
                let (Some(material), Some(transform)) = (material, transform) else {
                    continue;
                };
                out.meshes.push(PlacedModel {
                    object: id,
                    file: self.desc.folder().join(mesh.file.get_ref()),
                    material,
                    transform,
                });
                out.objects.push(named(object, i, material.unwrap_or(MaterialId(0))));
                continue;
            }
            let shape = self.keep(object.shape.get_ref().compile().map_err(|problem| {
                // A kind that has no better place for its problem means the whole shape.
                let span = problem.span.clone().or_else(|| Some(object.shape.span()));
                Problem { span, ..problem }
            }));
            let (Some(Some(material)), Some(shape), Some(transform)) = (material, shape, transform) else {
                continue;
            };
            out.geometry.add_shape(shape, transform);
            out.shape_objects.push(id);
            out.objects.push(named(object, i, material));
        }
        out
    }

    /// The material that is said, `Some(None)` where a mesh brings its own.
    fn material_of(&mut self, object: &ObjectDesc) -> Option<Option<MaterialId>> {
        let found = match (&object.material, object.shape.get_ref()) {
            (Some(name), _) => self.material_id(name).map(Some),
            (None, ShapeDesc::Mesh(_)) => Ok(None),
            (None, _) => {
                let message = "an object of this shape needs a `material`";
                Err(Problem::at(object.shape.span(), message).with_help("only a `shape.mesh` brings its own"))
            }
        };
        self.keep(found)
    }

    /// `Some(None)` where there is none, or one that changes nothing.
    fn transform_of(&mut self, object: &ObjectDesc) -> Option<Option<Transform>> {
        let Some(said) = &object.transform else {
            return Some(None);
        };
        let transform = self.keep(said.get_ref().compile(said.span()))?;
        Some((!transform.is_identity()).then_some(transform))
    }
}

fn named(object: &ObjectDesc, index: usize, material: MaterialId) -> Object {
    let name = object.name.as_ref().map(|n| n.get_ref().clone());
    Object {
        name: name.unwrap_or_else(|| format!("object {}", index + 1)),
        material,
    }
}
