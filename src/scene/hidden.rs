//! Objects that are hidden from some rays, holdouts and shadow catchers.

use super::{LitWorld, Object, ObjectId, RayKind, Scene};
use crate::geometry::Hit;

/// The part of an object in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ObjectRole {
    #[default]
    Ordinary,
    /// It cuts a hole into the picture: where the camera sees it, the picture is black and transparent.
    Holdout,
    /// Where the camera sees it, the picture shows only how other objects change its light.
    ShadowCatcher,
}

impl Scene {
    /// The object at a hit.
    pub fn object_of(&self, hit: &Hit) -> ObjectId {
        let Some(mesh) = self.geometry.mesh_of(hit.prim) else {
            let triangles = self.geometry.accel.geometry().triangles.len() as u32;
            return self.geometry.shape_objects[(hit.prim.index() - triangles) as usize];
        };
        let instance = self.geometry.instances.get(hit.instance.0 as usize);
        instance.map_or(mesh.object, |instance| instance.object)
    }

    /// Whether a ray of this kind passes the object at a hit in this world as if it were not there.
    #[inline]
    pub fn is_hidden(&self, hit: &Hit, from: RayKind, world: LitWorld) -> bool {
        let is_met = |object: &Object| {
            object.rays.is_met(from) && (world == LitWorld::Whole || object.role == ObjectRole::ShadowCatcher)
        };
        (self.hides || world == LitWorld::Catchers) && !is_met(self.object_at(hit))
    }

    /// The part in the picture of the object at a hit.
    pub fn role_at(&self, hit: &Hit) -> ObjectRole {
        self.object_at(hit).role
    }

    fn object_at(&self, hit: &Hit) -> &Object {
        &self.geometry.objects[self.object_of(hit).0 as usize]
    }

    /// Whether any object is hidden from some rays.
    pub fn hides(&self) -> bool {
        self.hides
    }

    /// Whether any object is a holdout.
    pub fn has_holdouts(&self) -> bool {
        self.has_role(ObjectRole::Holdout)
    }

    /// Whether any object is a shadow catcher.
    pub fn has_catchers(&self) -> bool {
        self.has_role(ObjectRole::ShadowCatcher)
    }

    fn has_role(&self, role: ObjectRole) -> bool {
        self.geometry.objects.iter().any(|object| object.role == role)
    }

    /// Whether rays that surfaces scatter meet other objects than shadow rays do. Then light sampling alone finds what lights
    /// bring: the two techniques look for different light.
    #[inline]
    pub fn samples_lights_only(&self) -> bool {
        self.samples_lights_only
    }
}
