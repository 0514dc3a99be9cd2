//! The scene of another time, made of the one that was compiled last.
//!
//! Colours, lights and the background cost no acceleration structure and no file, transforms the top of the structure. All else is
//! compiled again. Either way the scene has the bits of one that was compiled for the time alone.

use std::{
    cell::LazyCell,
    collections::{BTreeMap, BTreeSet},
};

use super::{
    Error,
    asset_errors::file_errors,
    background::{self, BackgroundLight},
    light_names::LightNames,
    materials::{MaterialNames, warn_of_gain},
    objects::moved_place,
};
use crate::{
    assets::{AssetError, Store, image::AlphaUse, model::ImageSource, store::ImageRequest},
    describe::{Diagnostics, SceneDesc},
    geometry::MAX_MAGNIFICATION,
    light::sky::Sky,
    material::{Emission, Material, MaterialId},
    scene::{LightId, ObjectId, Scene, SceneUpdate, ShadingUpdate},
    texture::{Bitmap, bitmap::ColorSpace},
    value::{Problem, Spanned},
};

/// A change of a description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Change {
    Material(usize),
    Light(usize),
    /// The light of the background, but for the file of its environment.
    Background,
    /// The rotation of its environment or its sky.
    BackgroundRotation,
    BackgroundVisible,
    Transform(usize),
    /// The material of an object.
    ObjectMaterial(usize),
    /// The transforms of nodes or the materials of a model, which [`SceneMotion`](super::SceneMotion) changes.
    Parts,
    /// Something else, for which the scene is compiled again.
    Other,
}

/// Makes scenes of other times.
#[derive(Default)]
pub struct Refresher {
    /// The picture of the background's environment, once it was needed.
    environment: Option<Bitmap>,
}

impl Refresher {
    /// Changes `scene`, so that it is that of `desc`, which differs from what it was compiled of by `changes`. Returns whether that
    /// was possible; if not, the scene is to be compiled again.
    ///
    /// # Errors
    /// A new value is wrong.
    pub fn refresh(
        &mut self,
        scene: &mut Scene,
        desc: &SceneDesc,
        changes: &BTreeSet<Change>,
        store: &Store,
    ) -> Result<bool, Error> {
        if changes.contains(&Change::Other) {
            return Ok(false);
        }
        let mut problems = Vec::new();
        let mut keep = |problem: Problem| problems.push(problem);
        let space = desc.render.working_space;
        let (mut shading, mut update) = (ShadingUpdate::default(), SceneUpdate::default());
        let (names, light_names) = (MaterialNames::new(desc), LightNames::new(desc));
        let own_lights = desc.lights.len() + usize::from(desc.background.sky.is_some());
        let mut is_alike = true;
        let mut painted = Vec::new();
        let parts = LazyCell::new(|| objects_with_instances(scene));
        for change in changes {
            match *change {
                Change::Material(at) => {
                    let entry = &desc.materials[at];
                    let Some(mut material) = names.material(entry).map_err(&mut keep).ok() else {
                        continue;
                    };
                    let Some(map) = names.normal_map(entry, &material).map_err(&mut keep).ok() else {
                        continue;
                    };
                    is_alike &= material.mixture().is_none() || names.tangled().is_none();
                    material.convert_colors(space);
                    let id = MaterialId(at as u32);
                    is_alike &= are_alike(scene.material(id), &material);
                    let name = desc.materials[at].name.get_ref();
                    warn_of_gain(name, &material, &scene.textures(), store.warnings());
                    shading.materials.push((id, material));
                    shading.normal_maps.push((id, map));
                }
                Change::Light(at) => {
                    let compiled = light_names.find(scene.origin, |find| desc.lights[at].light.compile(find));
                    if let Ok(mut light) = compiled.map_err(&mut keep) {
                        light.convert_colors(space);
                        shading.lights.push((LightId(at as u32), light));
                    }
                }
                Change::Background | Change::BackgroundRotation | Change::BackgroundVisible => {
                    let Some(sky) = background::sky(&desc.background).map_err(&mut keep).ok() else {
                        continue;
                    };
                    let light = self.light(scene, (desc, sky), changes, store);
                    match light.map_err(|errors| Error::assets(file_errors(errors), desc))? {
                        Some(BackgroundLight { radiance, sun }) => {
                            shading.background = Some(background::with_radiance(&desc.background, radiance, space));
                            let last = LightId((scene.lights.all().len() as u32).saturating_sub(1));
                            shading.lights.extend(sun.map(|sun| (last, sun)));
                        }
                        None => is_alike = false,
                    }
                }
                Change::ObjectMaterial(at) => {
                    let object = &desc.objects[at];
                    is_alike &= object.part.is_empty();
                    let named = |name: &Spanned<String>| {
                        desc.materials
                            .iter()
                            .position(|material| material.name.get_ref() == name.get_ref())
                    };
                    match object.material.as_ref().and_then(named) {
                        Some(material) => painted.push((ObjectId(at as u32), MaterialId(material as u32))),
                        // The compiler says what is wrong.
                        None => is_alike = false,
                    }
                }
                // The lights of models would have to move along.
                Change::Transform(_) if scene.lights.all().len() > own_lights => is_alike = false,
                Change::Transform(at) if !desc.objects[at].visible => {}
                Change::Transform(at) => {
                    let place = moved_place(&desc.objects[at], scene.origin).map_err(&mut keep).ok();
                    let Some(transform) = place.and_then(|place| place.transform) else {
                        continue;
                    };
                    is_alike &= transform.magnification().0 <= MAX_MAGNIFICATION;
                    match desc.objects[at].part.is_empty() {
                        true => update.transforms.push((ObjectId(at as u32), transform)),
                        false => {
                            let moved = parts.get(&(at as u32)).into_iter().flatten();
                            update
                                .transforms
                                .extend(moved.map(|object| (ObjectId(*object), transform)));
                        }
                    }
                }
                Change::Parts => {}
                Change::Other => is_alike = false,
            }
        }
        if let Some(diagnostics) = Diagnostics::new(&desc.source, problems) {
            return Err(Error::Invalid(diagnostics));
        }
        let has_moved = update.transforms.is_empty() || is_alike && scene.apply(&update).is_ok();
        let is_shaded = has_moved && is_alike && (shading.is_empty() || scene.reshade(shading).is_ok());
        Ok(is_shaded
            && painted
                .into_iter()
                .all(|(object, material)| paint(scene, object, material)))
    }

    /// The light of the background of `desc`; `None` if the scene has to be compiled again for it.
    fn light(
        &mut self,
        scene: &Scene,
        (desc, sky): (&SceneDesc, Option<Sky>),
        changes: &BTreeSet<Change>,
        store: &Store,
    ) -> Result<Option<BackgroundLight>, Vec<AssetError>> {
        let old = &scene.shading.background.radiance;
        if sky.is_none() && !changes.contains(&Change::Background) {
            let radiance = background::rotated(old, &desc.background);
            return Ok(Some(BackgroundLight { radiance, sun: None }));
        }
        // Alone the picture may get another resolution than among all images.
        if desc.background.environment.is_some() && !store.halved().is_empty() {
            return Ok(None);
        }
        let (space, warnings) = (desc.render.working_space, store.warnings());
        let sources = (sky.as_ref(), self.picture(desc, store)?);
        Ok(Some(background::light(&desc.background, sources, space, warnings)))
    }

    /// The picture of the environment of the background, which is read once.
    fn picture(&mut self, desc: &SceneDesc, store: &Store) -> Result<Option<&Bitmap>, Vec<AssetError>> {
        let Some(file) = desc.environment_file() else {
            return Ok(None);
        };
        if self.environment.is_none() {
            let request = ImageRequest {
                alpha: AlphaUse::Unused,
                ..ImageRequest::new(ImageSource::File(file), ColorSpace::Srgb)
            };
            self.environment = store.images(&[request])?.pop().map(|(_, picture)| picture);
        }
        Ok(self.environment.as_ref())
    }
}

/// The objects of the scene that have instances, by the object of the description that they are or belong to.
fn objects_with_instances(scene: &Scene) -> BTreeMap<u32, BTreeSet<u32>> {
    let mut objects: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for record in &scene.geometry.instances {
        let whole = scene.whole_object(record.object);
        objects.entry(whole.0).or_default().insert(record.object.0);
    }
    objects
}

/// Gives an object another material, if it has the same arrays with it.
fn paint(scene: &mut Scene, object: ObjectId, material: MaterialId) -> bool {
    let old = scene.geometry.objects[object.0 as usize].material;
    are_alike(scene.material(old), scene.material(material)) && scene.paint(object, material).is_ok()
}

/// Whether a scene with `new` in place of `old` has the same arrays: what emits light is never an instance, and the images of
/// opacities are decoded otherwise.
pub(super) fn are_alike(old: &Material, new: &Material) -> bool {
    let reach = |material: &Material| material.emission().map(|Emission { reach, .. }| reach);
    reach(old) == reach(new) && old.opacity_texture() == new.opacity_texture()
}
