//! Objects to geometry.

use super::Compiler;
use crate::{
    accel::{Geometry, Placed},
    scene::{Object, ObjectId},
};

/// The objects of a scene and what a ray can meet of them.
#[derive(Default)]
pub(super) struct Objects {
    pub geometry: Geometry,
    pub objects: Vec<Object>,
    /// Object of each of the geometry's shapes.
    pub shape_objects: Vec<ObjectId>,
}

impl Compiler<'_> {
    pub(super) fn objects(&mut self) -> Objects {
        let mut out = Objects::default();
        for (i, object) in self.desc.objects.iter().enumerate() {
            let material = self.material_id(&object.material);
            let material = self.keep(material);
            let shape = self.keep(object.shape.get_ref().compile().map_err(|problem| {
                // A kind that has no better place for its problem means the whole shape.
                let span = problem.span.clone().or_else(|| Some(object.shape.span()));
                crate::value::Problem { span, ..problem }
            }));
            let transform = match &object.transform {
                None => Some(None),
                Some(t) => self.keep(t.get_ref().compile(t.span())).map(Some),
            };
            let (Some(material), Some(shape), Some(transform)) = (material, shape, transform) else {
                continue;
            };
            let transform = transform.filter(|t| !t.is_identity()).map(|t| {
                out.geometry.transforms.push(t);
                out.geometry.transforms.len() as u32 - 1
            });
            out.geometry.shapes.push(Placed { shape, transform });
            out.shape_objects.push(ObjectId(out.objects.len() as u32));
            let name = object.name.as_ref().map(|n| n.get_ref().clone());
            out.objects.push(Object {
                name: name.unwrap_or_else(|| format!("object {}", i + 1)),
                material,
            });
        }
        out
    }
}
