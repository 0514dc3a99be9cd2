//! The lights that light the objects of a scene.

use super::{EmitterPrim, LightId, LightOrigin, LightSetId, LightSource, LitWorld, ObjectId, ObjectRole, Scene};

impl Scene {
    /// The object, or another origin, of a light.
    pub(super) fn origin_of(&self, light: LightId) -> LightOrigin {
        match self.lights.source(light) {
            LightSource::Analytic(_) => LightOrigin::Light(light),
            LightSource::Background => LightOrigin::Background,
            LightSource::Emitter(emitter) => {
                LightOrigin::Object(match self.lights.emitters().prim(emitter, &self.geometry.meshes) {
                    EmitterPrim::Shape(shape) => self.geometry.shape_objects[shape as usize],
                    EmitterPrim::Triangle(_, mesh) => mesh.object,
                })
            }
        }
    }

    /// The set of the lights that light an object.
    #[inline(always)]
    pub fn lit_by(&self, object: ObjectId) -> LightSetId {
        if self.has_links {
            self.geometry.objects[object.0 as usize].lit_by
        } else {
            LightSetId::default()
        }
    }

    /// Whether light of this origin is in a set.
    #[inline(always)]
    pub fn is_in(&self, set: LightSetId, origin: LightOrigin) -> bool {
        set == LightSetId::default() || self.shading.light_links.has(set, origin)
    }

    /// Whether some sampled lights do not light all objects, or not in all worlds.
    #[inline(always)]
    pub fn selects_lights(&self) -> bool {
        self.selects_lights
    }

    /// Whether a sampled light lights an object in this world.
    #[cold]
    #[inline(never)]
    pub fn is_lit(&self, object: ObjectId, light: LightId, world: LitWorld) -> bool {
        let origin = self.origin_of(light);
        let is_there = match (world, origin) {
            (LitWorld::Catchers, LightOrigin::Object(emitter)) => {
                self.geometry.objects[emitter.0 as usize].role == ObjectRole::ShadowCatcher
            }
            _ => true,
        };
        is_there && self.is_in(self.lit_by(object), origin)
    }
}
