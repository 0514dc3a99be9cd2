//! The places of a job's files, checked before the first ray.

use std::{
    collections::HashMap,
    fs,
    path::{Path, PathBuf},
};

use super::{Existing, Plan};
use crate::{assets::Files, error::Error, output};

/// Finds out whether the files of a job can be written: none of them is a file that the job reads, what exists is a regular
/// file, and the folders exist afterwards.
pub(super) fn check(plan: &Plan, inputs: &Files) -> Result<(), Error> {
    let targets = || plan.frames.iter().flat_map(|f| &f.files).map(|f| f.path.as_path());
    check_inputs(targets(), inputs)?;
    for path in plan
        .files
        .sidecars
        .iter()
        .filter_map(|sidecar| plan.sidecar_path(*sidecar))
    {
        check_inputs([path.as_path()].into_iter(), inputs)?;
        output::atomic::check(&path)?;
    }
    if plan.policy.existing == Existing::Fail
        && let Some(path) = targets().find(|path| path.exists())
    {
        return Err(Error::Exists { path: path.to_owned() });
    }
    for path in targets() {
        output::atomic::check_kind(path)?;
    }
    // The files of the first frame stand for the others, which lie in the same folders. A whole file that stays may be
    // read-only.
    for path in targets().take(plan.frames.first().map_or(0, |f| f.files.len())) {
        if plan.policy.existing != Existing::Skip || !path.exists() {
            output::atomic::check(path)?;
        } else {
            output::atomic::sweep(path);
        }
    }
    Ok(())
}

/// Refuses targets that are inputs, by whatever name or link.
fn check_inputs<'a>(targets: impl Iterator<Item = &'a Path>, inputs: &Files) -> Result<(), Error> {
    let read: HashMap<Identity, PathBuf> = inputs
        .manifest()
        .into_iter()
        .filter_map(|(path, _)| Some((identity(&path)?, path)))
        .collect();
    for target in targets {
        if let Some(input) = identity(target).and_then(|id| read.get(&id)) {
            return Err(Error::OverwritesInput {
                output: target.to_owned(),
                input: input.clone(),
            });
        }
    }
    Ok(())
}

/// The identity of a file: equal for all its names.
#[cfg(unix)]
type Identity = (u64, u64);

/// The device and the number of an existing file.
#[cfg(unix)]
fn identity(path: &Path) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    let file = fs::metadata(path).ok()?;
    Some((file.dev(), file.ino()))
}

/// The identity of a file: its path without links.
#[cfg(not(unix))]
type Identity = PathBuf;

/// The path of an existing file without links.
#[cfg(not(unix))]
fn identity(path: &Path) -> Option<Identity> {
    fs::canonicalize(path).ok()
}
