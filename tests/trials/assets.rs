//! Real model files, which are not part of the project: none makes the program panic, the sound ones render.
//!
//! They are in the folder that `BATCH_RENDER_ASSETS` names; a test whose files are not there is ignored.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

use batch_render::{
    assets::{Store, model::Model, model_formats::is_model},
    batch::{Job, Request},
    describe::Overrides,
    math::{Ray, Vec2},
};
use libtest_mimic::{Failed, Trial};
use rayon::prelude::*;

pub fn trials() -> Vec<Trial> {
    let cornell = "obj/cornell/cornell_box.obj";
    let mut trials = vec![
        asset_trial!("no model file makes a loader panic", &[], loads_or_says_why),
        asset_trial!(
            "a model whose textures are not there renders without them",
            &[cornell],
            move |folder| renders_without_textures(&folder.join(cornell)),
        ),
    ];
    for file in PLAIN {
        trials.push(asset_trial!(
            format!("something to see in {file}"),
            &[file],
            move |folder| fills_the_picture(&folder.join(file)),
        ));
    }
    trials
}

/// Loads a model; a panic is an error of this test.
fn load(path: &Path) -> Result<Model, String> {
    let store = Store::default();
    match catch_unwind(AssertUnwindSafe(|| store.model(&path.into()))) {
        Ok(Ok(model)) => Ok((*model).clone()),
        Ok(Err(e)) => Err(e.to_string()),
        Err(_) => panic!("panic: {}", path.display()),
    }
}

fn loads_or_says_why(folder: &Path) -> Result<(), Failed> {
    let mut files = crate::common::files(folder);
    files.retain(|file| is_model(file));
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
    let loaded = loaded.count();
    println!("{loaded} of {} loaded", files.len());
    if loaded == 0 {
        return Err("the folder has no model that loads".into());
    }
    Ok(())
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

fn fills_the_picture(path: &Path) -> Result<(), Failed> {
    let request = Request {
        overrides: Overrides::default().with("render.width", 32).with("render.height", 18),
        ..Request::default()
    };
    let job = Job::open(path, &request)?;
    let scene = job.compile()?;
    let camera = job.plan.frames[0].camera.camera(0.0);
    let rays: Vec<Ray> = (0..32 * 18)
        .filter_map(|i| {
            let film = Vec2::new((i % 32) as f32 + 0.5, (i / 32) as f32 + 0.5);
            camera.ray(film, Vec2::ZERO)
        })
        .collect();
    let mut hits = vec![None; rays.len()];
    scene.geometry.accel.nearest(&rays, &mut hits);
    let share = hits.iter().flatten().count() as f32 / rays.len() as f32;
    if share > 0.03 {
        Ok(())
    } else {
        Err(format!("{share} of the picture shows the model").into())
    }
}

fn renders_without_textures(path: &Path) -> Result<(), Failed> {
    let job = Job::open(path, &Request::default())?;
    job.compile()?;
    assert_eq!(job.placeholders(), 0);
    Ok(())
}
