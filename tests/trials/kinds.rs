//! Every kind has a scene in `scenes/kinds`, and it renders the same on any number of threads.

use crate::common::{Folder, repo};
use batch_render::{
    camera::CameraDesc,
    describe::BackgroundDesc,
    filter::FilterDesc,
    integrator::IntegratorDesc,
    light::LightDesc,
    material::MaterialDesc,
    sampler::SamplerDesc,
    shape::ShapeDesc,
    texture::{MappingDesc, PatternDesc},
};
use libtest_mimic::{Failed, Trial};

/// The names of all kinds of all registries, with the name of the registry.
const REGISTRIES: [(&str, &[&str]); 10] = [
    ("shape", ShapeDesc::NAMES),
    ("texture", PatternDesc::NAMES),
    ("mapping", MappingDesc::NAMES),
    ("material", MaterialDesc::NAMES),
    ("light", LightDesc::NAMES),
    ("camera", CameraDesc::NAMES),
    ("integrator", IntegratorDesc::NAMES),
    ("filter", FilterDesc::NAMES),
    ("sampler", SamplerDesc::NAMES),
    ("background", BackgroundDesc::NAMES),
];

pub fn trials() -> Vec<Trial> {
    let kinds: Vec<String> = REGISTRIES
        .iter()
        .flat_map(|(room, kinds)| kinds.iter().map(|kind| crate::common::kind_scene(room, kind)))
        .collect();
    let mut trials: Vec<Trial> = kinds
        .iter()
        .map(|kind| {
            let kind = kind.clone();
            trial!(format!("scene {kind}"), move || scene_renders(&kind))
        })
        .collect();
    let known: Vec<String> = kinds.iter().map(|k| format!("{k}.toml")).collect();
    trials.push(trial!("no scene without a kind", move || {
        let stray: Vec<_> = crate::common::names(&repo("scenes/kinds"))
            .into_iter()
            .filter(|n| n.ends_with(".toml") && !known.contains(n))
            .collect();
        if stray.is_empty() {
            Ok(())
        } else {
            Err(format!("{stray:?}").into())
        }
    }));
    trials
}

fn scene_renders(kind: &str) -> Result<(), Failed> {
    let scene = repo(&format!("scenes/kinds/{kind}.toml"));
    let folder = Folder::new();
    let small = ["--resolution", "48x27", "--samples", "2", "--progress", "none"];
    // Pictures are cut into other tiles for more threads, and each thread renders several.
    for threads in ["1", "7"] {
        let (png, exr) = (format!("{threads}.png"), format!("{threads}.exr"));
        let files = ["--threads", threads, "-o", &png, "-o", &exr];
        let output = folder.program().arg(&scene).args(small).args(files).output()?;
        if !output.status.success() {
            return Err(crate::common::stderr(&output).into());
        }
    }
    if folder.read("1.exr") != folder.read("7.exr") {
        return Err("seven threads make another picture than one".into());
    }
    let image = image::load_from_memory(&folder.read("1.png"))?.into_rgb8();
    let first = image.get_pixel(0, 0);
    if image.pixels().all(|p| p == first) {
        return Err("the picture is of one colour".into());
    }
    Ok(())
}
