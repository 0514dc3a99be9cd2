//! Objects that are hidden from some rays, and holdouts.

use super::{Object, ObjectId, RayKind, Scene};
use crate::geometry::Hit;

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

    /// Whether a ray of this kind passes the object at a hit as if it were not there.
    #[inline]
    pub fn is_hidden(&self, hit: &Hit, from: RayKind) -> bool {
        self.hides && !self.object_at(hit).rays.is_met(from)
    }

    /// Whether the object at a hit is a holdout.
    pub fn is_holdout(&self, hit: &Hit) -> bool {
        self.object_at(hit).holdout
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
        self.geometry.objects.iter().any(|object| object.holdout)
    }

    /// Whether rays that surfaces scatter meet other objects than shadow rays do. Then light sampling alone finds what lights bring: the
    /// two techniques look for different light.
    #[inline]
    pub fn samples_lights_only(&self) -> bool {
        self.samples_lights_only
    }
}
