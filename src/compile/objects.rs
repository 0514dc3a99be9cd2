//! Compilation of objects.

use super::{
    compiler::{Compiler, undefined},
    materials::MaterialNames,
    model_lights::LampOptions,
    place::ObjectPlace,
    placed::{NO_PARTS, PlacedModel},
    selection::{SelectedNodes, Selection},
};
use crate::{
    assets::{
        Store,
        model::{AnimationChoice, ModelChoice},
        motion::ModelEdits,
    },
    describe::{Entity, ObjectDesc, SceneDesc},
    material::MaterialId,
    math::{DAffine3, DVec3},
    scene::{ObjectBackFaces, ObjectId, ObjectRole},
    shape::ShapeDesc,
    value::{Problem, Spanned, UnknownName},
};

impl Compiler<'_> {
    /// Adds all objects to the scene; returns those with geometry in files.
    pub(super) fn objects(&mut self) -> Vec<PlacedModel> {
        let mut models = Vec::new();
        for (i, object) in self.desc.objects.iter().enumerate() {
            let material = self.material_of(object);
            let place = self.place_of(object, i);
            let name = name_of(object, i);
            if let ShapeDesc::Mesh(mesh) = object.shape.get_ref() {
                let (Some(material), Some(place)) = (material, place) else {
                    continue;
                };
                let file = mesh.file.get_ref();
                let edited_over_time = self.options.edited.get(&i);
                let mut edited = object.parts.edited();
                edited_over_time.into_iter().for_each(|others| edited.extend(others));
                let replaced: Vec<_> = object.parts.replaced().collect();
                let replaced = replaced.into_iter().filter_map(|(name, other)| {
                    let other = self.material_id(other);
                    Some((name.to_owned(), self.record(other)?))
                });
                let replaced = replaced.collect();
                let Some(displacement) = self.displacement_of(mesh) else {
                    continue;
                };
                // None are played here, and values decided that.
                let is_animated = self.options.animated.contains(&i);
                let undecided = || is_animated.then(|| AnimationChoice::Named(Vec::new()));
                let id = self.scene.object(&name, Some(file), material.unwrap_or(MaterialId(0)));
                self.object_settings(object, id);
                models.push(PlacedModel {
                    object: id,
                    described: i,
                    part_of: None,
                    selection: Selection::of(object),
                    nodes: SelectedNodes::default(),
                    file: self.desc.folder().join(file),
                    choice: ModelChoice {
                        scene: mesh.scene.clone(),
                        variant: mesh.variant.clone(),
                        is_varied: self.options.varied.contains(&i),
                        lights: mesh.lights,
                        light_units: mesh.light_units,
                        animation: mesh.animation.clone().or_else(undecided),
                        edited,
                        subdivision: mesh.subdivision(),
                        displacement,
                    },
                    playback: mesh.playback(),
                    edits: ModelEdits::default(),
                    is_edited_over_time: edited_over_time.is_some(),
                    replaced,
                    material,
                    place,
                    visible: object.visible,
                    moved: self.options.moved.contains(&i),
                    light_group: object.group.as_ref().map(|g| g.as_str().to_owned()),
                    point_radius: mesh.radius.map(|r| r.0),
                    lamps: LampOptions {
                        radius: mesh.light_radius,
                        factor: mesh.light_factor.map_or(1.0, |factor| factor.0),
                    },
                });
                continue;
            }
            let named = object.parts.names().map(|(.., span)| span);
            if let Some(span) = named.chain(object.node_patterns().map(Spanned::span)).next() {
                self.problems.push(Problem::at(span, NO_PARTS));
            }
            // With a transform the shape is in its own space, without one in world space.
            let origin = match &place {
                Some(place) if place.transform.is_some() => DVec3::ZERO,
                _ => self.origin,
            };
            let shape = self.record(object.shape.get_ref().compile(origin).map_err(|problem| {
                // A problem without a span belongs to the whole shape.
                let span = problem.span.clone().or_else(|| Some(object.shape.span()));
                Problem { span, ..problem }
            }));
            let (Some(Some(material)), Some(shape), Some(place)) = (material, shape, place) else {
                continue;
            };
            let id = match object.visible {
                true => self.scene.shape(&name, shape, place.transform, material),
                false => {
                    let id = self.scene.object(&name, None, material);
                    self.scene.hidden_part(id, None);
                    id
                }
            };
            self.object_settings(object, id);
        }
        self.model_parts(&mut models);
        models
    }

    /// Adds the parts of models that have settings of their own, after all objects.
    fn model_parts(&mut self, models: &mut Vec<PlacedModel>) {
        for whole in 0..models.len() {
            let object = &self.desc.objects[models[whole].described];
            for (number, part) in object.part.iter().enumerate() {
                let own = object.with_part(part);
                let Some(material) = self.material_of(&own) else {
                    continue;
                };
                let placed = models[whole].clone();
                let name = name_of(object, placed.described);
                let asset = object.shape.get_ref().mesh().map(|mesh| mesh.file.get_ref().as_str());
                let id = self.scene.object(&name, asset, material.unwrap_or(MaterialId(0)));
                self.scene.set_part_of(id, placed.object);
                self.object_settings(&own, id);
                models.push(PlacedModel {
                    object: id,
                    part_of: Some(whole),
                    selection: placed.selection.of_part(number),
                    material,
                    visible: own.visible,
                    light_group: own.group.as_ref().map(|g| g.as_str().to_owned()),
                    ..placed
                });
            }
        }
    }

    fn object_settings(&mut self, object: &ObjectDesc, id: ObjectId) {
        let role = match (
            object.holdout,
            object.shadow_catcher.as_ref().filter(|given| *given.get_ref()),
        ) {
            (true, Some(given)) => {
                let message = "a holdout is no `shadow_catcher`: it shows nothing at all";
                return self.problems.push(Problem::at(given.span(), message));
            }
            (true, None) => ObjectRole::Holdout,
            (false, Some(_)) => ObjectRole::ShadowCatcher,
            (false, None) => ObjectRole::Ordinary,
        };
        self.scene.set_object_visibility(id, object.ray_visibility, role);
        if let Some(backs) = &object.back_faces {
            if *backs.get_ref() == ObjectBackFaces::File && !is_model(object) {
                let message = "only the file of a model says which backs are seen";
                self.problems.push(Problem::at(backs.span(), message));
            }
            self.scene.set_object_back_faces(id, Some(*backs.get_ref()));
        }
        if let Some(lights) = self.lights_of(object) {
            self.scene.set_object_lights(id, lights);
        }
        if let Some(group) = &object.group {
            self.scene.set_object_light_group(id, group.as_str());
        }
    }

    /// The object's material; `Some(None)` if its mesh has its own.
    fn material_of(&mut self, object: &ObjectDesc) -> Option<Option<MaterialId>> {
        let found = match (&object.material, object.shape.get_ref()) {
            (Some(name), _) => self.material_id(name).map(Some),
            (None, ShapeDesc::Mesh(_)) => Ok(None),
            (None, _) => {
                let message = "an object of this shape needs a `material`";
                Err(Problem::at(object.shape.span(), message).with_help("only a `shape.mesh` brings its own"))
            }
        };
        self.record(found)
    }

    fn place_of(&mut self, object: &ObjectDesc, index: usize) -> Option<ObjectPlace> {
        let place = match self.options.moved.contains(&index) {
            true => moved_place(object, self.origin),
            false => place(object, self.origin),
        };
        self.record(place)
    }
}

/// The place of an object that never moves.
fn place(object: &ObjectDesc, origin: DVec3) -> Result<ObjectPlace, Problem> {
    let Some(given) = &object.transform else {
        return Ok(ObjectPlace::in_world(origin));
    };
    let world_from_object = given.get_ref().compile(given.span())?;
    let too_far = || Problem::at(given.span(), "the transform has no inverse");
    ObjectPlace::new(world_from_object, origin).ok_or_else(too_far)
}

/// Whether its geometry comes from a file, which may bring materials and lights.
pub(super) fn is_model(object: &ObjectDesc) -> bool {
    object.shape.get_ref().mesh().is_some()
}

/// Whether a mesh of the scene plays animations.
pub fn plays_animations(desc: &SceneDesc) -> bool {
    let plays = |object: &ObjectDesc| {
        let animation = object.shape.get_ref().mesh().and_then(|mesh| mesh.animation.as_ref());
        animation.is_some_and(|choice| !choice.is_empty())
    };
    desc.objects.iter().any(plays)
}

/// Checks the names that an object or a material uses: those of materials and textures, and of what its
/// model has, if `store` knows the file.
///
/// # Errors
/// The message of a name that is not there.
pub fn check_names(desc: &SceneDesc, entity: Entity, store: &Store) -> Result<(), String> {
    let message = |problem: Problem| match problem.help {
        Some(help) => format!("{} ({help})", problem.message),
        None => problem.message,
    };
    match entity {
        Entity::Material(at) => {
            let names = MaterialNames::new(desc);
            let compiled = names.material(&desc.materials[at]).map_err(message)?;
            let tangled = compiled.mixture().and_then(|_| names.tangled());
            tangled.map_or(Ok(()), |problem| Err(message(problem)))
        }
        Entity::Object(at) => {
            let object = &desc.objects[at];
            if let Some(name) = &object.material
                && !desc
                    .materials
                    .iter()
                    .any(|material| material.name.get_ref() == name.get_ref())
            {
                let known = desc.materials.iter().map(|material| &material.name);
                return Err(message(undefined("material", name.get_ref(), name.span(), known)));
            }
            let Some(mesh) = object.shape.get_ref().mesh() else {
                return Ok(());
            };
            let path = desc.folder().join(mesh.file.get_ref());
            let Some(report) = store.model_report(&path) else {
                return Ok(());
            };
            let clips: Vec<&str> = report.clips.iter().map(|clip| clip.name.as_str()).collect();
            let variants: Vec<&str> = report.variants.iter().map(String::as_str).collect();
            let unknown = |what: &str, name: &str, known: &[&str]| {
                let unknown = UnknownName::new(what, name, known.iter().copied());
                let unknown = match known.is_empty() {
                    true => unknown.with_fallback(Some("the model has none".to_owned())),
                    false => unknown,
                };
                Err(format!("{unknown}: {}", path.display()))
            };
            let played = match &mesh.animation {
                Some(AnimationChoice::Named(names)) => names.as_slice(),
                _ => &[],
            };
            if let Some(name) = played.iter().find(|name| !clips.contains(&name.as_str())) {
                return unknown("animation", name, &clips);
            }
            match &mesh.variant {
                Some(name) if !variants.contains(&name.as_str()) => unknown("variant", name, &variants),
                _ => Ok(()),
            }
        }
        Entity::Light(_) | Entity::Texture(_) | Entity::Background | Entity::Camera => Ok(()),
    }
}

/// The place, at one time, of an object that moves: it always has a transform.
pub(super) fn moved_place(object: &ObjectDesc, origin: DVec3) -> Result<ObjectPlace, Problem> {
    let span = object.transform.as_ref().map_or(object.shape.span(), Spanned::span);
    let too_far = || Problem::at(span, "the transform has no inverse");
    ObjectPlace::moved(world_from_object(object)?, origin).ok_or_else(too_far)
}

/// The transform of an object to the world.
pub(super) fn world_from_object(object: &ObjectDesc) -> Result<DAffine3, Problem> {
    match &object.transform {
        Some(given) => given.get_ref().compile(given.span()),
        None => Ok(DAffine3::IDENTITY),
    }
}

/// The name of an object by its index.
pub(super) fn name_of(object: &ObjectDesc, index: usize) -> String {
    let name = object.name.as_ref().map(|n| n.get_ref().clone());
    name.unwrap_or_else(|| format!("object {}", index + 1))
}
