//! The lights of objects, which scene files name.

use super::{compiler::Compiler, objects::is_model};
use crate::{
    describe::{LIGHT_GROUP, LightGroupName, ObjectDesc},
    material::MaterialId,
    scene::{LightId, LightOrigin, LightSet, ObjectId},
    value::{Problem, Spanned, UnknownName},
};

/// The name of the background among lights.
const BACKGROUND: &str = "background";

impl Compiler<'_> {
    /// The lights that light an object; `None` if all do.
    pub(super) fn lights_of(&mut self, object: &ObjectDesc) -> Option<LightSet> {
        if object.lights.is_none() && object.exclude_lights.is_empty() {
            return None;
        }
        let mut set = if object.lights.is_some() {
            LightSet::NONE
        } else {
            LightSet::ALL
        };
        for name in object.lights.iter().flatten() {
            let origins = self.named_lights(name);
            self.record(origins)
                .into_iter()
                .flatten()
                .for_each(|origin| set.add(origin));
        }
        for name in &object.exclude_lights {
            let origins = self.named_lights(name);
            self.record(origins)
                .into_iter()
                .flatten()
                .for_each(|origin| set.remove(origin));
        }
        Some(set)
    }

    /// The light that a name means: of lights, objects and light groups of this name, or of the background.
    fn named_lights(&self, name: &Spanned<String>) -> Result<Vec<LightOrigin>, Problem> {
        let all = self.all_lights();
        let is_meant = |known: &KnownLight| {
            let group = known.group.as_deref();
            match name.get_ref().strip_prefix(LIGHT_GROUP) {
                Some(wanted) => group == Some(wanted),
                None => known.name == *name.get_ref() || group == Some(name.get_ref().as_str()),
            }
        };
        let found: Vec<LightOrigin> = all
            .iter()
            .filter(|known| is_meant(known))
            .map(|known| known.origin)
            .collect();
        if !found.is_empty() {
            return Ok(found);
        }
        let mut known: Vec<String> = all.iter().map(|known| known.name.clone()).collect();
        let has_prefix = name.get_ref().starts_with(LIGHT_GROUP);
        for group in all.into_iter().filter_map(|known| known.group) {
            let group = if has_prefix {
                format!("{LIGHT_GROUP}{group}")
            } else {
                group
            };
            if !known.contains(&group) {
                known.push(group);
            }
        }
        Err(UnknownName::new("light", name.get_ref(), known.iter().map(String::as_str)).at(name.span()))
    }

    /// All that may light an object.
    fn all_lights(&self) -> Vec<KnownLight> {
        let group = |group: Option<&LightGroupName>| group.map(|group| group.as_str().to_owned());
        let name = |given: &Option<Spanned<String>>, what: &str, number: usize| {
            let given = given.as_ref().map(|name| name.get_ref().clone());
            given.unwrap_or_else(|| format!("{what} {number}"))
        };
        let lights = self.desc.lights.iter().enumerate().map(|(i, light)| KnownLight {
            name: name(&light.name, "light", i + 1),
            group: group(light.group.as_ref()),
            origin: LightOrigin::Light(LightId(i as u32)),
        });
        let objects = self.desc.objects.iter().enumerate();
        let objects = objects
            .filter(|(_, object)| self.may_emit(object))
            .map(|(i, object)| KnownLight {
                name: name(&object.name, "object", i + 1),
                group: group(object.group.as_ref()),
                origin: LightOrigin::Object(ObjectId(i as u32)),
            });
        // Parts of models follow all objects.
        let models = self.desc.objects.iter().enumerate();
        let models = models.filter(|(_, object)| is_model(object));
        let parts = models.flat_map(|(i, object)| object.part.iter().map(move |part| (i, object, part)));
        let parts = parts
            .zip(self.desc.objects.len()..)
            .map(|((i, object, part), id)| KnownLight {
                name: name(&object.name, "object", i + 1),
                group: group(part.group.as_ref().or(object.group.as_ref())),
                origin: LightOrigin::Object(ObjectId(id as u32)),
            });
        let background = KnownLight {
            name: BACKGROUND.to_owned(),
            group: group(self.desc.background.group.as_ref()),
            origin: LightOrigin::Background,
        };
        lights.chain(objects).chain(parts).chain([background]).collect()
    }

    /// Whether an object may emit light. Models bring materials and lights of their own.
    fn may_emit(&self, object: &ObjectDesc) -> bool {
        let material = object.material.as_ref().and_then(|name| self.material_id(name).ok());
        let emits = |MaterialId(at)| {
            let material = self.scene.materials().nth(at as usize);
            material.is_some_and(|(_, material)| material.emission().is_some())
        };
        is_model(object) || material.is_some_and(emits)
    }
}

/// A light, by which names mean it.
struct KnownLight {
    name: String,
    group: Option<String>,
    origin: LightOrigin,
}
