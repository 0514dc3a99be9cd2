//! Warnings about keys of objects that have no effect beside the others.

use super::{
    objects::{is_model, name_of},
    options::LoadOptions,
    placed::{LoadedModels, PlacedModel},
};
use crate::{
    describe::{FileKind, ObjectDesc, SceneDesc},
    material::{MaterialId, MaterialKind as _},
    scene::SceneBuilder,
    shape::mesh::{BoundaryRule, MeshDesc},
    value::{Spanned, one_line},
    warnings::{WarningKind, Warnings},
};

/// Warns of keys of the objects of `desc` that have no effect. `scene` has the objects, the models
/// among them `placed` and `loaded`.
pub(super) fn warn(
    desc: &SceneDesc,
    scene: &SceneBuilder,
    (placed, loaded): (&[PlacedModel], &LoadedModels),
    options: &LoadOptions,
    warnings: &Warnings,
) {
    let warn = |index: usize, key: &str, why: &str| {
        let name = name_of(&desc.objects[index], index);
        let name = one_line(&name, 80);
        let text = format!("object `{name}`: `{key}` has no effect, because {why}");
        warnings.add_topic(WarningKind::UNUSED_SETTING, key, name, text);
    };
    for (index, object) in desc.objects.iter().enumerate() {
        if let Some(key) = object.shape.get_ref().mesh().and_then(unused_of_subdivision) {
            warn(index, key, "the mesh has no `subdivide`");
        }
        let parts = object.part.iter().map(|part| object.with_part(part));
        for own in parts.chain([object.clone()]) {
            if let Some(key) = role(&own).filter(|_| !own.ray_visibility.camera) {
                warn(
                    index,
                    key,
                    "the camera does not see it (`ray_visibility.camera = false`)",
                );
            }
        }
    }
    for placed in placed.iter().filter(|placed| placed.part_of.is_some()) {
        if placed.nodes.is_empty() {
            let why = "`nodes` of the object and later parts leave it no node";
            warn(placed.described, "part", why);
        }
    }
    let background = &desc.background;
    if background.backdrop.is_some() && !background.visible && desc.source.kind == FileKind::Scene {
        let text = "`backdrop` has no effect, because the background is not visible (`visible = false`)";
        warnings.add_topic(WarningKind::UNUSED_SETTING, "backdrop", "background", text);
    }
    // Values over frames may make a material shine.
    if options.changes_materials {
        return;
    }
    let is_dark = |id: MaterialId| {
        scene
            .materials()
            .nth(id.0 as usize)
            .is_none_or(|(_, m)| m.emission().is_none())
    };
    for (index, object) in desc.objects.iter().enumerate().filter(|(_, o)| o.group.is_some()) {
        let of_object = |material: &Spanned<String>| {
            let known = desc
                .materials
                .iter()
                .position(|m| m.name.get_ref() == material.get_ref());
            known.is_some_and(|at| is_dark(MaterialId(at as u32)))
        };
        if !is_model(object) && object.material.as_ref().is_some_and(of_object) {
            warn(index, "group", NO_LIGHT);
        }
    }
    for (placed, model) in placed.iter().zip(&loaded.models) {
        let has_lights = placed.choice.lights == Some(true) && !model.lights.is_empty();
        let is_changed = placed.is_edited_over_time || model.motion.is_some();
        if placed.light_group.is_none() || has_lights || is_changed {
            continue;
        }
        let is_all_dark = match placed.material {
            Some(id) => is_dark(id),
            None => {
                let mut replaced = placed.replaced.iter();
                let mut own = model.materials.iter();
                own.all(|m| m.surface.emission().is_none()) && replaced.all(|(_, id)| is_dark(*id))
            }
        };
        if is_all_dark {
            warn(placed.described, "group", NO_LIGHT);
        }
    }
}

const NO_LIGHT: &str = "it emits no light";

/// The key that makes the object other than ordinary in the picture.
fn role(object: &ObjectDesc) -> Option<&'static str> {
    match &object.shadow_catcher {
        _ if object.holdout => Some("holdout"),
        Some(given) if *given.get_ref() => Some("shadow_catcher"),
        _ => None,
    }
}

/// The first key of the rules of subdivision that a mesh has which is not subdivided.
fn unused_of_subdivision(mesh: &MeshDesc) -> Option<&'static str> {
    let given = [
        ("subdivision", mesh.subdivision.is_some()),
        ("boundary", mesh.boundary != BoundaryRule::default()),
        ("crease_angle", mesh.crease_angle.is_some()),
        ("crease_sharpness", mesh.crease_sharpness.is_some()),
    ];
    let first = given.into_iter().find(|(_, is_given)| *is_given)?;
    mesh.subdivision().is_none().then_some(first.0)
}
