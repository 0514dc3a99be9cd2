//! The first step of compilation: a description and the files that it names become a [`SceneBuilder`].

use std::cell::RefCell;

use super::{Error, Instancing, background, compiler::Compiler, models};
use crate::{
    assets::{Store, model::ImageSource},
    describe::{Diagnostics, SceneDesc},
    scene::{Background, SceneBuilder},
    texture::{BitmapId, Texture, image::ImageDesc},
};

/// Loads everything of a scene but its acceleration structure and its tables of lights, on the threads of the current
/// rayon pool: [`SceneBuilder::build`] makes those. Models that `store` has are not loaded again.
pub fn load(desc: &SceneDesc, store: &Store, instancing: Instancing) -> Result<SceneBuilder, Error> {
    let mut compiler = Compiler::new(desc);
    compiler.textures();
    compiler.materials();
    let placed = compiler.objects();
    compiler.lights();
    let environment = compiler.environment();
    if let Some(diagnostics) = Diagnostics::new(&desc.source, compiler.problems) {
        return Err(Error::Invalid(diagnostics));
    }
    let (mut scene, mut images) = (compiler.scene, compiler.images);
    // Problems of models and of images are reported together.
    let mut models = models::ModelPlacer {
        scene: &mut scene,
        images: &mut images,
        instancing,
    };
    let placed = models.place(&placed, store);
    let has_environment = environment.is_some();
    images.extend(environment);
    let mut bitmaps = match (placed, store.images(&images)) {
        (Ok(()), Ok(bitmaps)) => bitmaps,
        (placed, bitmaps) => {
            let errors = placed.err().into_iter().chain(bitmaps.err()).flatten();
            return Err(Error::Assets(errors.collect()));
        }
    };
    let picture = bitmaps.pop_if(|_| has_environment);
    for bitmap in bitmaps {
        scene.bitmap(bitmap);
    }
    warn_energy_gain(&scene);
    if let Some(group) = &desc.background.group {
        scene.set_background_light_group(group.as_str());
    }
    scene.set_background(Background {
        radiance: background::radiance(&desc.background, picture.as_ref()),
        visible: desc.background.visible,
    });
    Ok(scene)
}

impl Compiler<'_> {
    fn lights(&mut self) {
        for entry in &self.desc.lights {
            let Some(light) = self.record(entry.light.compile()) else {
                continue;
            };
            match &entry.group {
                Some(group) => self.scene.grouped_light(light, group.as_str()),
                None => self.scene.light(light),
            }
        }
    }

    fn textures(&mut self) {
        let folder = self.desc.folder();
        for entry in &self.desc.textures {
            let images = RefCell::new(&mut self.images);
            let find = |image: &ImageDesc| {
                let file = ImageSource::File(folder.join(image.file.get_ref()));
                let request = (file, image.color_space);
                let mut images = images.borrow_mut();
                let at = images.iter().position(|i| *i == request).unwrap_or_else(|| {
                    images.push(request);
                    images.len() - 1
                });
                Ok(BitmapId(at as u32))
            };
            let pattern = entry.pattern.compile(&find);
            let mapping = entry.mapping.compile();
            if let (Some(pattern), Some(mapping)) = (self.record(pattern), self.record(mapping)) {
                self.scene.texture(Texture {
                    mapping,
                    transform: entry.transform.compile(),
                    pattern,
                });
            }
        }
    }
}

/// Warns of materials that send back more light than arrives.
fn warn_energy_gain(scene: &SceneBuilder) {
    let textures = scene.textures();
    for (name, material) in scene.materials() {
        let max_reflectance = material.max_reflectance(&textures);
        if max_reflectance > 1.0 {
            tracing::warn!("material `{name}` sends back more light than arrives, {max_reflectance} of it");
        }
    }
}
