//! Light groups: named sets of lights, each of which has a pass of its own.

use super::{LightId, ObjectId};

/// An index into the groups of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightGroup(pub u16);

/// The light groups of a scene. Lights without a group are in the first, which has no name.
#[derive(Clone, Debug)]
pub struct LightGroups {
    names: Vec<String>,
    /// The group of each analytic light, and of each object; those beyond the end have none.
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
    /// Returns the group of this name, and adds it if it is new.
    pub fn named(&mut self, name: &str) -> LightGroup {
        let known = self.names.iter().position(|n| n == name);
        let at = known.unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        });
        LightGroup(u16::try_from(at).unwrap_or(0))
    }

    /// The names of all groups, by their indices.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Puts the `light`th of the scene's own lights into `group`.
    pub fn set_light(&mut self, light: usize, group: LightGroup) {
        put(&mut self.lights, light, group);
    }

    /// Puts the light that an object emits into `group`.
    pub fn set_object(&mut self, object: ObjectId, group: LightGroup) {
        put(&mut self.objects, object.0 as usize, group);
    }

    /// Puts the light of the background into `group`.
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

    pub(super) fn of_analytic(&self, light: LightId) -> LightGroup {
        self.lights.get(light.0 as usize).copied().unwrap_or_default()
    }
}
