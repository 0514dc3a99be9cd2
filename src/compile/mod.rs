//! Compilation: a description and its files become a [`Scene`], flat and immutable.
//!
//! [`load()`] reads all files and reports their errors; [`SceneBuilder::build`] makes the acceleration structure and the lights,
//! which a job without frames to render does not need.
//!
//! All problems of a pass are reported together: first contradictions and undefined names, then missing and broken files.
//!
//! [`SceneBuilder::build`]: crate::scene::SceneBuilder::build

use crate::{
    accel::BuildOptions,
    assets::Store,
    describe::SceneDesc,
    scene::Scene,
    warnings::{WarningKind, Warnings},
};

mod asset_errors;
mod background;
mod bounds;
mod compiler;
pub mod default_scene;
mod displacement;
mod error;
mod instancing;
mod light_links;
mod light_names;
mod load;
mod materials;
mod model_lights;
mod models;
mod motion;
mod nesting;
mod objects;
mod options;
mod origin;
mod place;
mod placed;
mod points;
mod refresh;
mod selection;
mod textures;
mod unused;

pub use asset_errors::AssetErrors;
pub use bounds::visible_bounds;
pub use error::Error;
pub use instancing::Instancing;
pub use load::{check_file, load, load_moving, origin};
pub use motion::{LastPoses, SceneMotion};
pub use objects::{check_names, plays_animations};
pub use options::LoadOptions;
pub use refresh::{Change, Refresher};

/// Compiles a scene and builds its acceleration structure, on the threads of the current rayon pool.
pub fn scene(desc: &SceneDesc, accel: impl Into<BuildOptions>) -> Result<Scene, Error> {
    scene_with(desc, accel, &Store::default())
}

/// Compiles a scene with the models that `store` has already loaded.
pub fn scene_with(desc: &SceneDesc, accel: impl Into<BuildOptions>, store: &Store) -> Result<Scene, Error> {
    scene_instancing(desc, accel, store, Instancing::default())
}

/// Compiles a scene with a choice of instances.
pub fn scene_instancing(
    desc: &SceneDesc,
    accel: impl Into<BuildOptions>,
    store: &Store,
    instancing: Instancing,
) -> Result<Scene, Error> {
    let options = LoadOptions {
        instancing,
        ..LoadOptions::default()
    };
    scene_from(desc, accel, store, &options)
}

/// Compiles a scene with these options.
pub fn scene_from(
    desc: &SceneDesc,
    accel: impl Into<BuildOptions>,
    store: &Store,
    options: &LoadOptions,
) -> Result<Scene, Error> {
    Ok(moving_scene(desc, accel.into(), store, options)?.0)
}

/// Compiles a scene with these options; returns what its models move as well.
pub fn moving_scene(
    desc: &SceneDesc,
    accel: BuildOptions,
    store: &Store,
    options: &LoadOptions,
) -> Result<(Scene, SceneMotion), Error> {
    let (scene, motion) = load_moving(desc, store, options)?;
    let scene = scene.build(accel).map_err(|cause| Error::Build {
        cause,
        path: desc.source.path.clone(),
    })?;
    warn_dark_emitters(&scene, store.warnings());
    Ok((scene, motion))
}

/// Warns of emitters that give no light because they have no area.
pub(crate) fn warn_dark_emitters(scene: &Scene, warnings: &Warnings) {
    let (surfaces, are) = match scene.lights.dark_emitters() {
        0 => return,
        1 => ("1 surface", "it is"),
        n => (&*format!("{n} surfaces"), "they are"),
    };
    let text = format!("{surfaces} that should shine without area: {are} left out");
    warnings.add_topic(WarningKind::NO_AREA, "emitters", "emitters", text);
}
