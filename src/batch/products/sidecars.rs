//! Writing the files beside the pictures of a job.

use std::{collections::HashSet, fs, path::Path};

use serde::{Serialize, de::DeserializeOwned};

use super::{
    coco::Coco,
    colmap,
    ids::{Ids, IdsOfFrames},
    labels::{Labels, has_names_of_frames},
    metadata::Sidecar,
    transforms,
};
use crate::{
    assets::camera_path::transforms::Transforms,
    batch::{CameraRig, InputHash, Plan},
    error::Error,
    output::{Obstacle, OutputError, atomic, job_file::FolderGate},
    render::Cancel,
    scene::Scene,
    warnings::WarningKind,
};

/// Writes the files beside the pictures of a plan, with those of its frames in `done`, which are on disk. A job that renders some frames of a
/// sequence keeps what others have written of the other frames.
pub(in crate::batch) fn write(
    (plan, inputs): (&Plan, InputHash),
    (rig, scene, labels): (&CameraRig, &Scene, Labels),
    done: &HashSet<i32>,
    cancel: Option<&Cancel>,
) -> Result<(), Error> {
    let path = |sidecar: Sidecar| match plan.files.sidecars.contains(&sidecar) {
        true => plan.sidecar_path(sidecar),
        false => None,
    };
    if let Some(path_of_transforms) = path(Sidecar::Transforms) {
        let mut own = transforms::of_job((plan, inputs), rig, done)?;
        let _gate = FolderGate::close(&atomic::folder_of(&path_of_transforms), cancel);
        match transforms::read::<Transforms>(&path_of_transforms) {
            Ok(None) => {}
            Ok(Some(others)) => transforms::join(&mut own, others, plan, &path_of_transforms),
            Err(_) if !plan.is_chunk => {}
            Err(cause) => {
                let path = path_of_transforms.display();
                let text = format!("the frames of other jobs are lost, {cause}: {path}");
                plan.warnings.add_live(WarningKind::LOST_FRAMES, path, text);
            }
        }
        write_json(&path_of_transforms, &own)?;
        if let Some(images) = path(Sidecar::Colmap) {
            write_colmap(&atomic::folder_of(&images), &own)?;
        }
    }
    if let (Some(path), Some(instances)) = (path(Sidecar::Coco), labels.instances) {
        let mut own = instances.file(plan.files.categories, done);
        let folder = atomic::folder_of(&path);
        let _gate = FolderGate::close(&folder, cancel);
        if plan.files.keeps_labels
            && let Some(others) = read(&path)?
        {
            own.join(others, plan, &folder);
        }
        write_json(&path, &own)?;
    }
    match (path(Sidecar::Ids), labels.names) {
        (None, _) => Ok(()),
        (Some(path), None) => Ok(write_json(&path, &Ids::new(scene))?),
        (Some(path), Some(names)) => {
            let mut own = names.file(done);
            let _gate = FolderGate::close(&atomic::folder_of(&path), cancel);
            if plan.is_chunk
                && let Some(others) = read(&path)?
            {
                own.join(others, |frame| transforms::picture_name(plan, frame));
            }
            Ok(write_json(&path, &own)?)
        }
    }
}

/// Checks whether the labels of other jobs, which this one keeps, can be read.
///
/// # Errors
/// A file of them is damaged.
pub(in crate::batch) fn check(plan: &Plan) -> Result<(), Error> {
    let has = |sidecar: &Sidecar| plan.files.sidecars.contains(sidecar) && plan.files.keeps_labels;
    if let Some(path) = Some(Sidecar::Coco).filter(has).and_then(|coco| plan.sidecar_path(coco)) {
        read::<Coco>(&path)?;
    }
    let joins_names = plan.is_chunk && has_names_of_frames(plan);
    if let Some(path) = plan.sidecar_path(Sidecar::Ids).filter(|_| joins_names) {
        read::<IdsOfFrames>(&path)?;
    }
    Ok(())
}

/// The labels of other jobs in the file at `path`; `None` where there is none.
fn read<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, Error> {
    transforms::read(path).map_err(|cause| Error::OtherLabels {
        cause,
        path: path.to_owned(),
    })
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
