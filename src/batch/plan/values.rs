//! The values of a job that change over time: of a table, and of the camera path.

use std::{collections::HashMap, path::PathBuf, sync::Arc};

use crate::{
    assets::{
        Files,
        camera_path::{self, CameraPathFormat, ValueColumns, load_values},
    },
    batch::Request,
    describe::{SceneDesc, ValueFile, Values},
    error::Error,
};

/// Reads the tables of values of a job; `of_scene` is that of its scene file.
pub(in crate::batch) fn tables(
    of_scene: Option<PathBuf>,
    request: &Request,
    inputs: &Files,
) -> Result<Vec<ValueFile>, Error> {
    let options = request.path_options(None);
    let table = request
        .values
        .clone()
        .or(of_scene)
        .map(|path| (path, ValueColumns::All));
    let camera_path = request
        .camera_path
        .clone()
        .filter(|path| CameraPathFormat::of_path(path).is_none_or(CameraPathFormat::holds_values))
        .map(|path| (path, ValueColumns::BesideCamera));
    let mut files = Vec::new();
    for (path, which) in table.into_iter().chain(camera_path) {
        let table = load_values(&path, which, &options, inputs);
        if which == ValueColumns::BesideCamera && table.is_err() {
            // Errors of the path itself come first.
            camera_path::load(&path, None, &options, inputs)?;
        }
        let table = table?;
        if !table.columns.is_empty() {
            files.push(ValueFile { path, table });
        }
    }
    Ok(files)
}

/// The values of these tables, if there are any.
pub(in crate::batch) fn values(desc: &SceneDesc, files: &[ValueFile]) -> Result<Option<Arc<Values>>, Error> {
    if files.is_empty() {
        return Ok(None);
    }
    let mut known = HashMap::new();
    for file in files {
        for column in &file.table.columns {
            if let Some(other) = known.insert(column.name.clone(), file.path.clone()) {
                return Err(Error::SetTwice {
                    path: file.path.clone(),
                    name: column.name.clone(),
                    other: other.display().to_string(),
                });
            }
        }
    }
    Ok(Some(Arc::new(Values::new(desc, files)?)))
}
