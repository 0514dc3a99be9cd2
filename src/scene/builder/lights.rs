//! Lights of a scene that is assembled.

use super::SceneBuilder;
use crate::{
    light::{Light, Profile, ProfileId},
    scene::{LightId, LightOrigin, ObjectId},
};

impl SceneBuilder {
    /// Adds a profile that lights refer to.
    pub fn profile(&mut self, profile: Profile) -> ProfileId {
        self.profiles.push(profile);
        ProfileId(self.profiles.len() as u32 - 1)
    }

    pub fn light(&mut self, light: Light) {
        self.lights.push(light);
    }

    /// Adds a light to a light group.
    pub fn grouped_light(&mut self, light: Light, group: &str) {
        let group = self.light_groups.named(group);
        self.light_groups.set_light(self.lights.len(), group);
        self.light(light);
    }

    /// Puts the light that an object emits into a light group.
    pub fn set_object_light_group(&mut self, object: ObjectId, group: &str) {
        let group = self.light_groups.named(group);
        self.light_groups.set_object(object, group);
    }

    /// Puts the light of the background into a light group.
    pub fn set_background_light_group(&mut self, group: &str) {
        let group = self.light_groups.named(group);
        self.light_groups.set_background(group);
    }

    /// Adds a light that is part of the background: it is in its light group, and lights the same objects.
    pub fn background_light(&mut self, light: Light) {
        let at = self.lights.len();
        self.light_groups.set_light(at, self.light_groups.of_background());
        self.light_links.set_owner(LightId(at as u32), LightOrigin::Background);
        self.light(light);
    }

    /// The analytic lights so far.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }
}
