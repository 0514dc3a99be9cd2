//! The first step of compilation: a description and its files become a [`SceneBuilder`].

use std::path::Path;

use super::{
    Error,
    asset_errors::{AssetErrors, FileError, file_errors},
    background::{self, BackgroundLight},
    compiler::Compiler,
    light_names::LightNames,
    materials::warn_of_gain,
    models::ModelPlacer,
    motion::{Movables, SceneMotion},
    options::LoadOptions,
    origin::SceneOrigin,
    placed::{self, LoadedModels, PlacedModel},
    unused,
};
use crate::{
    assets::{
        AssetError, MemoryKind, Store,
        image::AlphaUse,
        store::{EnvironmentKey, ImageRequest, ModelRequest},
    },
    describe::{Diagnostics, SceneDesc},
    light::sky::Sky,
    material::Material,
    math::DVec3,
    scene::SceneBuilder,
    texture::bitmap::ColorSpace,
    value::{Span, one_line},
    warnings::{WarningKind, Warnings},
};

/// A scene before its files are loaded.
pub(super) struct Compiled {
    scene: SceneBuilder,
    images: Vec<ImageRequest>,
    pub placed: Vec<PlacedModel>,
    /// The picture of the background's environment.
    environment: Option<ImageRequest>,
    sky: Option<Sky>,
}

impl Compiled {
    /// Compiles the description itself, relative to `origin`.
    fn around(origin: DVec3, desc: &SceneDesc, options: &LoadOptions) -> Result<Self, Error> {
        let mut compiler = Compiler::new(desc, origin, options);
        compiler.textures();
        compiler.materials();
        let placed = compiler.objects();
        compiler.lights();
        let environment = compiler.environment();
        let sky = compiler.record(background::sky(&desc.background)).flatten();
        match Diagnostics::new(&desc.source, compiler.problems) {
            Some(diagnostics) => Err(Error::Invalid(diagnostics)),
            None => Ok(Self {
                scene: compiler.scene,
                images: compiler.images,
                placed,
                environment,
                sky,
            }),
        }
    }
}

/// Loads the models of a scene, and compiles its description relative to the origin that suits all objects.
pub(super) fn around_models(
    desc: &SceneDesc,
    store: &Store,
    options: &LoadOptions,
) -> Result<(Compiled, Result<LoadedModels, Vec<FileError>>), Error> {
    let mut origin = SceneOrigin::new(desc, options.eye);
    let first = options.origin.unwrap_or_else(|| origin.choose());
    let mut compiled = Compiled::around(first, desc, options)?;
    let loaded = load_models(desc, store, &mut compiled.placed, options.time)?;
    if options.origin.is_some() {
        return Ok((compiled, loaded));
    }
    if let Ok(loaded) = &loaded {
        let placed = compiled.placed.iter().zip(loaded.own_bounds());
        origin.add(placed.map(|(placed, bounds)| placed.place.world_box(first, bounds)));
    }
    let chosen = origin.choose();
    if chosen != first {
        let again = Compiled::around(chosen, desc, options)?;
        let old = std::mem::replace(&mut compiled, again).placed;
        for (placed, old) in compiled.placed.iter_mut().zip(old) {
            (placed.edits, placed.nodes) = (old.edits, old.nodes);
        }
    }
    Ok((compiled, loaded))
}

/// Loads the models of placed objects at `time`, in s; or says what is wrong with each that is broken.
fn load_models(
    desc: &SceneDesc,
    store: &Store,
    placed: &mut [PlacedModel],
    time: f64,
) -> Result<Result<LoadedModels, Vec<FileError>>, Error> {
    let requests: Vec<ModelRequest> = placed.iter().map(PlacedModel::request).collect();
    store.keep_models(&requests);
    let models = match store.models(&requests) {
        Ok(models) => models,
        Err(errors) => {
            let of_object = |(request, error): (usize, AssetError)| FileError {
                error,
                object: Some(placed[request].described),
            };
            return Ok(Err(errors.into_iter().map(of_object).collect()));
        }
    };
    let unknown = placed::unknown_parts(desc, placed, &models);
    if let Some(diagnostics) = Diagnostics::new(&desc.source, unknown) {
        return Err(Error::Invalid(diagnostics));
    }
    placed::choose_parts(desc, placed, &models);
    Ok(Ok(LoadedModels::new(placed, models, time)))
}

/// Loads a file that the value at `span` of `desc` names, a model, an image or a profile, with the files that it names itself, and
/// drops it. Models that `known` has were loaded before.
///
/// # Errors
/// Those that [`load`] has, as far as they are of this file.
pub fn check_file(
    (desc, span): (&SceneDesc, &Span),
    path: &Path,
    store: &Store,
    options: &LoadOptions,
    known: &mut Vec<ModelRequest>,
) -> Result<(), Error> {
    let origin = SceneOrigin::new(desc, options.eye).choose();
    let compiled = Compiled::around(origin, desc, options)?;
    let (mut scene, mut images, mut placed) = (compiled.scene, compiled.images, compiled.placed);
    images.extend(compiled.environment);
    images.retain(|image| image.source.name() == path);
    placed.retain(|own| own.file == path && own.part_of.is_none() && !known.contains(&own.request()));
    // The images of a model are needed where its materials are shown.
    known.extend(
        placed
            .iter()
            .filter(|own| own.material.is_none())
            .map(PlacedModel::request),
    );
    let mut models = placer(&mut scene, &mut images, store, options);
    let placing = load_models(desc, store, &mut placed, options.time)?
        .and_then(|loaded| models.place(&placed, &loaded).map_err(file_errors));
    let profiles = LightNames::new(desc).load(desc.folder(), store.files());
    let others = [store.images(&images).err(), profiles.err()].map(|errors| file_errors(errors.unwrap_or_default()));
    let errors: Vec<_> = placing.err().into_iter().chain(others).flatten().collect();
    match errors.is_empty() {
        true => Ok(()),
        false => Err(Error::Assets(AssetErrors::of_scene(errors, desc, Some(span)))),
    }
}

/// Adds models to a scene.
fn placer<'a>(
    scene: &'a mut SceneBuilder,
    images: &'a mut Vec<ImageRequest>,
    store: &'a Store,
    options: &LoadOptions,
) -> ModelPlacer<'a> {
    ModelPlacer {
        scene,
        images,
        instancing: options.instancing,
        warnings: store.warnings(),
        memory: store.files().memory(),
        movables: Movables::default(),
    }
}

/// The origin that suits a scene. Models that `store` does not have are loaded.
pub fn origin(desc: &SceneDesc, store: &Store, options: &LoadOptions) -> Result<DVec3, Error> {
    let (compiled, loaded) = around_models(desc, store, options)?;
    loaded.map_err(|errors| Error::assets(errors, desc))?;
    Ok(compiled.scene.origin())
}

/// Loads a scene without its acceleration structure and lights, which [`SceneBuilder::build`] makes, on the threads of the
/// current rayon pool. Models that `store` already has are not loaded again.
pub fn load(desc: &SceneDesc, store: &Store, options: &LoadOptions) -> Result<SceneBuilder, Error> {
    Ok(load_moving(desc, store, options)?.0)
}

/// Loads a scene in the same way, and returns what its models move as well, see [`SceneMotion::update`].
pub fn load_moving(
    desc: &SceneDesc,
    store: &Store,
    options: &LoadOptions,
) -> Result<(SceneBuilder, SceneMotion), Error> {
    let (compiled, loaded) = around_models(desc, store, options)?;
    let Compiled {
        mut scene,
        mut images,
        placed,
        environment,
        sky,
    } = compiled;
    let memory = store.files().memory();
    memory.release(MemoryKind::Shapes);
    memory
        .take(
            MemoryKind::Shapes,
            scene.geometry().shapes.len() as u64 * SceneBuilder::SHAPE_BYTES,
        )
        .map_err(|cause| Error::Memory {
            cause,
            path: desc.source.path.clone(),
        })?;
    // Problems of models and of images are reported together.
    let mut models = placer(&mut scene, &mut images, store, options);
    let motion = loaded.and_then(|loaded| {
        models.place(&placed, &loaded).map_err(file_errors)?;
        unused::warn(desc, models.scene, (&placed, &loaded), options, store.warnings());
        Ok(SceneMotion::new(placed, loaded.at_rest, models.movables))
    });
    for bitmap in scene.opacity_bitmaps() {
        images[bitmap.0 as usize].alpha = AlphaUse::Opacity;
    }
    let working_space = desc.render.working_space;
    let intensity = (desc.background.environment.as_ref()).map_or(1.0, |given| given.get_ref().intensity.0);
    let kept = environment.as_ref();
    let kept = kept.and_then(|picture| store.background(picture, intensity, working_space));
    let environment = environment.filter(|_| kept.is_none());
    let has_environment = environment.is_some();
    images.extend(environment);
    let light_names = LightNames::new(desc);
    let profiles = light_names.load(desc.folder(), store.files());
    let (motion, mut bitmaps, profiles) = match (motion, store.images(&images), profiles) {
        (Ok(motion), Ok(bitmaps), Ok(profiles)) => (motion, bitmaps, profiles),
        (motion, bitmaps, profiles) => {
            let others = [bitmaps.err(), profiles.err()].map(|errors| file_errors(errors.unwrap_or_default()));
            let errors = motion.err().into_iter().chain(others);
            return Err(Error::assets(errors.flatten().collect(), desc));
        }
    };
    light_names.warn_dark(desc, &profiles, store.warnings());
    for profile in profiles {
        scene.profile(profile);
    }
    let picture = bitmaps.pop_if(|_| has_environment);
    let mut keys = Vec::new();
    for (key, bitmap) in bitmaps {
        keys.push(key);
        scene.bitmap(bitmap);
    }
    scene.convert_colors(working_space, |bitmap| {
        images[bitmap.0 as usize].color_space == ColorSpace::Srgb
    });
    warn_energy_gain(&scene, store.warnings());
    warn_invisible(&scene, store.warnings());
    if let Some(group) = &desc.background.group {
        scene.set_background_light_group(group.as_str());
    }
    let (environment, BackgroundLight { radiance, sun }) = match kept {
        Some((key, radiance)) => {
            let radiance = background::rotated(&radiance, &desc.background);
            (Some(key), BackgroundLight { radiance, sun: None })
        }
        None => {
            let (key, picture) = picture.unzip();
            let key = key.flatten().map(|picture| EnvironmentKey {
                picture,
                intensity,
                working_space,
            });
            let given = &desc.background;
            let sources = (sky.as_ref(), picture.as_ref());
            (key, background::light(given, sources, working_space, store.warnings()))
        }
    };
    if let Some(sun) = sun {
        scene.background_light(sun);
    }
    scene.set_background(background::with_radiance(&desc.background, radiance, working_space));
    Ok((scene, motion.with_images(keys, environment)))
}

impl Compiler<'_> {
    fn lights(&mut self) {
        let names = LightNames::new(self.desc);
        for entry in &self.desc.lights {
            let light = names.find(self.origin, |find| entry.light.compile(find));
            let Some(light) = self.record(light) else {
                continue;
            };
            match &entry.group {
                Some(group) => self.scene.grouped_light(light, group.as_str()),
                None => self.scene.light(light),
            }
        }
    }
}

/// Warns of materials that nobody can see.
fn warn_invisible(scene: &SceneBuilder, warnings: &Warnings) {
    let textures = scene.textures();
    let is_invisible = |(_, (_, material)): &(usize, (&str, &Material))| material.is_invisible(&textures);
    for (i, (name, _)) in scene.materials().enumerate().filter(is_invisible) {
        let shown = match name {
            "" => format!("number {i}"),
            name => format!("`{}`", one_line(name, 80)),
        };
        let text = format!("nothing of the material {shown} is seen: its opacity is 0 everywhere");
        warnings.add(WarningKind::INVISIBLE, shown, text);
    }
}

/// Warns of materials that reflect more light than they receive.
fn warn_energy_gain(scene: &SceneBuilder, warnings: &Warnings) {
    let textures = scene.textures();
    for (name, material) in scene.materials() {
        warn_of_gain(name, material, &textures, warnings);
    }
}
