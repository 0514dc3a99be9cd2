//! Real model files, which are not part of the project: none makes the program panic, the sound ones render.
//!
//! They are in the folder that `BATCH_RENDER_ASSETS` names; where there is none, nothing is tested.

mod common;

use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
};

use batch_render::{
    assets::{
        Store,
        model::Model,
        store::{MissingAssets, is_model},
    },
    batch::{Job, Request},
    compile,
    error::Error,
    math::Ray,
};
use rayon::prelude::*;

fn models(folder: &Path, out: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|e| e.path())
        .collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            models(&path, out);
        } else if is_model(&path) {
            out.push(path);
        }
    }
}

/// Loads a model; a panic is an error of this test.
fn load(path: &Path) -> Result<Model, String> {
    let store = Store::default();
    match catch_unwind(AssertUnwindSafe(|| store.model(path))) {
        Ok(Ok(model)) => Ok((*model).clone()),
        Ok(Err(e)) => Err(e.to_string()),
        Err(_) => panic!("panic: {}", path.display()),
    }
}

#[test]
fn no_model_file_makes_a_loader_panic() {
    let Some(folder) = common::assets() else { return };
    let mut files = Vec::new();
    models(&folder, &mut files);
    let loaded = files.par_iter().filter(|path| match load(path) {
        Ok(model) => {
            assert!(model.meshes.iter().all(|m| m.validate().is_ok()), "{}", path.display());
            true
        }
        Err(message) => {
            assert!(message.contains(&path.display().to_string()), "{message}");
            println!("{message}");
            false
        }
    });
    println!("{} of {} loaded", loaded.count(), files.len());
}

/// Models of nothing but triangles, colours and textures.
const PLAIN: [&str; 14] = [
    "gltf/khronos/Box/glTF/Box.gltf",
    "gltf/khronos/Box/glTF-Binary/Box.glb",
    "gltf/khronos/Box/glTF-Embedded/Box.gltf",
    "gltf/khronos/Box With Spaces/glTF/Box With Spaces.gltf",
    "gltf/khronos/BoxInterleaved/glTF/BoxInterleaved.gltf",
    "gltf/khronos/BoxTextured/glTF/BoxTextured.gltf",
    "gltf/khronos/BoxTextured/glTF-Binary/BoxTextured.glb",
    "gltf/khronos/Cube/glTF/Cube.gltf",
    "gltf/khronos/Duck/glTF/Duck.gltf",
    "gltf/khronos/Duck/glTF-Binary/Duck.glb",
    "gltf/khronos/Avocado/glTF/Avocado.gltf",
    "gltf/khronos/DamagedHelmet/glTF-Binary/DamagedHelmet.glb",
    "obj/models/stanford-bunny.obj",
    "obj/dragon/dragon_res3.obj",
];

#[test]
fn plain_models_are_scenes_with_something_to_see() {
    let Some(folder) = common::assets() else { return };
    for file in PLAIN {
        let path = folder.join(file);
        if !path.is_file() {
            println!("skipped: {file} is not there");
            continue;
        }
        let request = Request {
            resolution: Some([32, 18]),
            ..Request::default()
        };
        let job = Job::open(&path, &request).unwrap_or_else(|e| panic!("{e}"));
        let scene = job.compile().unwrap_or_else(|e| panic!("{e}"));
        let camera = job.plan.frames[0].shot.camera(0.0);
        let rays: Vec<Ray> = (0..32 * 18)
            .filter_map(|i| {
                let film = batch_render::math::Vec2::new((i % 32) as f32 + 0.5, (i / 32) as f32 + 0.5);
                camera.ray(film, batch_render::math::Vec2::ZERO)
            })
            .collect();
        let mut hits = vec![None; rays.len()];
        scene.accel.nearest(&rays, &mut hits);
        let share = hits.iter().flatten().count() as f32 / rays.len() as f32;
        assert!(share > 0.03, "{file}: {share} of the picture shows the model");
    }
}

#[test]
fn a_model_without_its_textures_renders_with_placeholders() {
    let Some(folder) = common::assets() else { return };
    let path = folder.join("obj/cornell/cornell_box.obj");
    if !path.is_file() {
        println!("skipped: cornell_box.obj is not there");
        return;
    }
    let open = |missing_assets| {
        let request = Request {
            missing_assets,
            ..Request::default()
        };
        let job = Job::open(&path, &request).unwrap_or_else(|e| panic!("{e}"));
        (job.compile().map(|_| ()), job.placeholders())
    };
    assert!(matches!(
        open(MissingAssets::Error),
        (Err(Error::Compile(compile::Error::Assets(_))), 0)
    ));
    let (scene, replaced) = open(MissingAssets::Placeholder);
    assert!(scene.is_ok() && replaced > 0, "{replaced}");
}
