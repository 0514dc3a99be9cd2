//! The settings of objects and materials that were added.

use super::SceneBuilder;
use crate::{
    material::MaterialId,
    scene::{
        LightId, LightOrigin, LightSet, MaterialBackFaces, NodeId, ObjectBackFaces, ObjectId, ObjectRole, RayVisibility,
    },
};

impl SceneBuilder {
    /// Makes an object a part of another, whose nodes it shares names and numbers with.
    pub(crate) fn set_part_of(&mut self, object: ObjectId, whole: ObjectId) {
        self.objects[object.0 as usize].part_of = Some(whole);
    }

    /// Sets the rays that meet an object, and its part in the picture.
    pub fn set_object_visibility(&mut self, object: ObjectId, rays: RayVisibility, role: ObjectRole) {
        let object = &mut self.objects[object.0 as usize];
        (object.rays, object.role) = (rays, role);
    }

    /// Sets the backs of all surfaces of an object, whatever their materials say.
    pub fn set_object_back_faces(&mut self, object: ObjectId, backs: Option<ObjectBackFaces>) {
        self.objects[object.0 as usize].back_faces = backs;
    }

    /// Sets the backs of surfaces of a material.
    pub fn set_material_back_faces(&mut self, material: MaterialId, backs: MaterialBackFaces) {
        let at = material.0 as usize;
        if self.back_faces.len() <= at {
            self.back_faces.resize(at + 1, MaterialBackFaces::default());
        }
        self.back_faces[at] = backs;
    }

    /// Sets the lights that light an object. All lights do beyond the 65,535th set of lights.
    pub fn set_object_lights(&mut self, object: ObjectId, lights: LightSet) {
        self.objects[object.0 as usize].lit_by = self.light_links.add(lights).unwrap_or_default();
    }

    /// Makes the last light part of an object, so that it lights what the object lights. Called after
    /// [`SceneBuilder::set_object_lights`].
    pub(crate) fn own_last_light(&mut self, owner: ObjectId) {
        if let Some(last) = self.lights.len().checked_sub(1) {
            self.light_links
                .set_owner(LightId(last as u32), LightOrigin::Object(owner));
        }
    }

    /// Names a part of an object that is not visible, and which keeps its matte and its number.
    pub(crate) fn hidden_part(&mut self, object: ObjectId, node: Option<NodeId>) {
        self.hidden.push((object, node));
    }

    /// Sets the material of those parts of an object that have none of their own.
    pub(crate) fn set_object_material(&mut self, object: ObjectId, material: MaterialId) {
        self.objects[object.0 as usize].material = material;
    }
}
