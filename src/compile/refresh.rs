//! The scene of another time, made of the one that was compiled last.
//!
//! Colours, lights and the background cost no acceleration structure and no file, transforms the top of the structure. All else is
//! compiled again. Either way the scene has the bits of one that was compiled for the time alone.

use std::collections::BTreeSet;

use super::{Error, background, materials::TextureNames, objects::moved_place};
use crate::{
    assets::{AssetError, Store, image::AlphaUse, model::ImageSource, store::ImageRequest},
    describe::{Diagnostics, SceneDesc},
    geometry::MAX_MAGNIFICATION,
    material::{Emission, Material, MaterialId},
    scene::{Background, LightId, ObjectId, Scene, SceneUpdate, ShadingUpdate},
    texture::{Bitmap, bitmap::ColorSpace},
    value::Problem,
};

/// What has changed in a description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Change {
    Material(usize),
    Light(usize),
    /// The background, but for the file of its environment.
    Background,
    Transform(usize),
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
        let names = TextureNames::new(desc);
        let mut is_alike = true;
        for change in changes {
            match *change {
                Change::Material(at) => {
                    let Some(mut material) = names.material(&desc.materials[at]).map_err(&mut keep).ok() else {
                        continue;
                    };
                    material.convert_colors(space);
                    let id = MaterialId(at as u32);
                    is_alike &= are_alike(scene.material(id), &material);
                    shading.materials.push((id, material));
                }
                Change::Light(at) => {
                    let compiled = desc.lights[at].light.compile(scene.origin);
                    if let Ok(mut light) = compiled.map_err(&mut keep) {
                        light.convert_colors(space);
                        shading.lights.push((LightId(at as u32), light));
                    }
                }
                // Alone it may get another resolution than among all images.
                Change::Background if desc.background.environment.is_some() && !store.halved().is_empty() => {
                    is_alike = false;
                }
                Change::Background => {
                    let radiance = match self.picture(desc, store) {
                        Ok(picture) => background::radiance(&desc.background, picture, space, store.warnings()),
                        Err(errors) => return Err(Error::Assets(errors)),
                    };
                    let visible = desc.background.visible;
                    shading.background = Some(Background { radiance, visible });
                }
                Change::Transform(at) if !desc.objects[at].visible => {}
                Change::Transform(at) => {
                    let place = moved_place(&desc.objects[at], scene.origin).map_err(&mut keep).ok();
                    let Some(transform) = place.and_then(|place| place.transform) else {
                        continue;
                    };
                    is_alike &= transform.magnification().0 <= MAX_MAGNIFICATION;
                    update.transforms.push((ObjectId(at as u32), transform));
                }
                Change::Other => is_alike = false,
            }
        }
        if let Some(diagnostics) = Diagnostics::new(&desc.source, problems) {
            return Err(Error::Invalid(diagnostics));
        }
        let has_moved = update.transforms.is_empty() || is_alike && scene.apply(&update).is_ok();
        Ok(is_alike && has_moved && (shading.is_empty() || scene.reshade(shading).is_ok()))
    }

    /// The picture of the environment of the background, which is read once.
    fn picture(&mut self, desc: &SceneDesc, store: &Store) -> Result<Option<&Bitmap>, Vec<AssetError>> {
        let Some(environment) = &desc.background.environment else {
            return Ok(None);
        };
        if self.environment.is_none() {
            let file = desc.folder().join(environment.get_ref().file.get_ref());
            let request = ImageRequest {
                alpha: AlphaUse::Unused,
                ..ImageRequest::new(ImageSource::File(file), ColorSpace::Srgb)
            };
            self.environment = store.images(&[request])?.pop();
        }
        Ok(self.environment.as_ref())
    }
}

/// Whether a scene with `new` in place of `old` has the same arrays: what emits light is never an instance, and the images of
/// opacities are decoded otherwise.
pub(super) fn are_alike(old: &Material, new: &Material) -> bool {
    let reach = |material: &Material| material.emission().map(|Emission { reach, .. }| reach);
    reach(old) == reach(new) && old.opacity_texture() == new.opacity_texture()
}
