//! Writing the files beside the pictures of a job.

use std::{fs, path::Path};

use serde::Serialize;

use super::{coco::Instances, colmap, ids::Ids, metadata::Sidecar, transforms};
use crate::{
    assets::camera_path::transforms::Transforms,
    batch::{CameraRig, FrameFailure, InputHash, Plan},
    error::Error,
    output::{Obstacle, OutputError, atomic, job_file::FolderGate},
    render::Cancel,
    scene::Scene,
};

/// Writes the files beside the pictures of a plan, but for frames that `failures` names. A job that renders some frames of a
/// sequence keeps what others have written of the other frames.
pub(in crate::batch) fn write(
    (plan, inputs): (&Plan, InputHash),
    (rig, scene, instances): (&CameraRig, &Scene, Option<Instances>),
    failures: &[FrameFailure],
    cancel: Option<&Cancel>,
) -> Result<(), Error> {
    let path = |sidecar: Sidecar| match plan.files.sidecars.contains(&sidecar) {
        true => plan.sidecar_path(sidecar),
        false => None,
    };
    if let Some(path_of_transforms) = path(Sidecar::Transforms) {
        let mut own = transforms::of_job((plan, inputs), rig, failures)?;
        let _gate = FolderGate::close(&atomic::folder_of(&path_of_transforms), cancel);
        if plan.is_chunk
            && let Some(others) = transforms::read(&path_of_transforms, &plan.warnings)
        {
            transforms::join(&mut own, others, plan, &path_of_transforms);
        }
        write_json(&path_of_transforms, &own)?;
        if let Some(images) = path(Sidecar::Colmap) {
            write_colmap(&atomic::folder_of(&images), &own)?;
        }
    }
    if let (Some(path), Some(instances)) = (path(Sidecar::Coco), instances) {
        let mut own = instances.file(scene, failures);
        let _gate = FolderGate::close(&atomic::folder_of(&path), cancel);
        if plan.is_chunk
            && let Some(others) = transforms::read(&path, &plan.warnings)
        {
            own.join(others, plan, &path);
        }
        write_json(&path, &own)?;
    }
    if let Some(path) = path(Sidecar::Ids) {
        write_json(&path, &Ids::new(scene))?;
    }
    Ok(())
}

fn write_json(path: &Path, content: &impl Serialize) -> Result<(), OutputError> {
    let text = serde_json::to_string_pretty(content).expect("numbers and texts are JSON") + "\n";
    atomic::write(path, |out| Ok(out.write_all(text.as_bytes())?))
}

/// Writes the files of a reconstruction into `folder`, which is made.
fn write_colmap(folder: &Path, transforms: &Transforms) -> Result<(), OutputError> {
    fs::create_dir_all(folder).map_err(|source| OutputError::Create {
        source: atomic::folder_problem(source, folder),
        path: folder.to_owned(),
        obstacle: Obstacle::Folder,
    })?;
    let files = colmap::files(transforms).map(|(name, text)| (folder.join(name), text));
    atomic::write_together(&files)
}
