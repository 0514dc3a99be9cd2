//! Camera paths from files.
//!
//! A format is one file and one row of [`FORMATS`]. Poses of all of them become those of a camera that looks along its -z with +y
//! up; the axes of the world, its origin and its unit stay as they are. Intrinsics in pixels become the camera `pinhole`.

use std::{
    io,
    path::{Path, PathBuf},
};

use super::Files;

mod chan;
pub mod colmap;
mod convert;
mod csv;
mod format;
mod formats;
mod gltf_nodes;
mod held;
pub mod keys;
mod opencv;
mod options;
mod problem;
mod source;
pub mod still;
pub mod transforms;
mod tum;

pub use convert::{Conversion, Converted, convert};
pub use csv::{
    document::PathDocument,
    edit::EditError,
    values::{ValueCell, ValueColumn, ValueColumns, ValueRow, ValueTable},
};
pub use format::CameraPathFormat;
pub use formats::{CameraPathError, FORMATS, files_of, load};
pub use options::CameraPathOptions;
pub use problem::{PathProblem, PathProblems};
pub use source::Source;

/// Why there are no values.
#[derive(Debug, thiserror::Error)]
pub enum ValueTableError {
    #[error("there is no such table of values: {}", path.display())]
    NotFound { path: PathBuf },
    #[error("cannot read the table of values: {source}: {}", path.display())]
    Io { path: PathBuf, source: io::Error },
    /// One line for every problem.
    #[error("{}", problems.display(path))]
    Invalid { path: PathBuf, problems: PathProblems },
}

/// Loads the values in a CSV file.
///
/// # Errors
/// The file cannot be read, or its contents are invalid.
pub fn load_values(
    path: &Path,
    which: ValueColumns,
    options: &CameraPathOptions,
    files: &Files,
) -> Result<ValueTable, ValueTableError> {
    let owned = || path.to_owned();
    let bytes = files.read(path).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => ValueTableError::NotFound { path: owned() },
        _ => ValueTableError::Io { path: owned(), source },
    })?;
    ValueTable::read(&bytes, which, options).map_err(|problems| ValueTableError::Invalid {
        path: owned(),
        problems,
    })
}

#[cfg(test)]
mod tests;
