//! Names for lights that belong together, so that a picture can be parted by them.

use super::{EmitterPrim, LightId, LightSource, ObjectId, Scene};

/// An index into the groups of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightGroup(pub u16);

/// The groups of a scene: what is in none is in the first, which has no name.
#[derive(Clone, Debug)]
pub struct LightGroups {
    names: Vec<String>,
    /// The group of each analytic light, and of each object; those beyond the end are in none.
    lights: Vec<LightGroup>,
    objects: Vec<LightGroup>,
    background: LightGroup,
}

impl Default for LightGroups {
    fn default() -> Self {
        Self {
            names: vec![String::new()],
            lights: Vec::new(),
            objects: Vec::new(),
            background: LightGroup::default(),
        }
    }
}

fn put(list: &mut Vec<LightGroup>, at: usize, group: LightGroup) {
    if list.len() <= at {
        list.resize(at + 1, LightGroup::default());
    }
    list[at] = group;
}

impl LightGroups {
    /// The group of this name, which is a new one where there was none.
    pub fn named(&mut self, name: &str) -> LightGroup {
        let known = self.names.iter().position(|n| n == name);
        let at = known.unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        });
        LightGroup(u16::try_from(at).unwrap_or(0))
    }

    /// By their numbers.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Puts the `light`th of the scene's own lights into `group`.
    pub fn set_light(&mut self, light: usize, group: LightGroup) {
        put(&mut self.lights, light, group);
    }

    /// Puts what shines of an object into `group`.
    pub fn set_object(&mut self, object: ObjectId, group: LightGroup) {
        put(&mut self.objects, object.0 as usize, group);
    }

    /// Puts the sky into `group`.
    pub fn set_background(&mut self, group: LightGroup) {
        self.background = group;
    }

    /// The group of the background.
    #[cold]
    pub fn of_background(&self) -> LightGroup {
        self.background
    }

    /// The group of an object that emits light.
    #[cold]
    pub fn of_object(&self, object: ObjectId) -> LightGroup {
        self.objects.get(object.0 as usize).copied().unwrap_or_default()
    }

    fn of_analytic(&self, light: LightId) -> LightGroup {
        self.lights.get(light.0 as usize).copied().unwrap_or_default()
    }
}

impl Scene {
    /// The group that `light` is in. Few ask.
    #[cold]
    pub fn group_of(&self, light: LightId) -> LightGroup {
        match self.lights.source(light) {
            LightSource::Analytic(_) => self.shading.light_groups.of_analytic(light),
            LightSource::Background => self.shading.light_groups.of_background(),
            LightSource::Emitter(emitter) => {
                let object = match self.lights.emitters().prim(emitter, &self.geometry.meshes) {
                    EmitterPrim::Shape(shape) => self.geometry.shape_objects[shape as usize],
                    EmitterPrim::Triangle(_, mesh) => mesh.object,
                };
                self.shading.light_groups.of_object(object)
            }
        }
    }
}
