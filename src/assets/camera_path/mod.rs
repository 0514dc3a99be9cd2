//! Camera paths from files.
//!
//! A format is one file and one row of [`FORMATS`].

use std::{
    io,
    path::{Path, PathBuf},
};

use super::Files;
use crate::{camera::path::CameraPath, value::one_of};

mod csv;
mod options;
mod problem;

pub use csv::{
    document::PathDocument,
    edit::EditError,
    values::{ValueCell, ValueColumn, ValueColumns, ValueRow, ValueTable},
};
pub use options::CameraPathOptions;
pub use problem::{PathProblem, PathProblems};

/// A format of camera paths.
#[derive(Debug)]
pub struct CameraPathFormat {
    pub name: &'static str,
    /// File extensions, in lower case.
    pub extensions: &'static [&'static str],
    read: fn(&[u8], &CameraPathOptions) -> Result<CameraPath, PathProblems>,
}

/// All formats.
pub const FORMATS: &[CameraPathFormat] = &[CameraPathFormat {
    name: "csv",
    extensions: &["csv", "tsv"],
    read: csv::read,
}];

/// Why there is no camera path.
#[derive(Debug, thiserror::Error)]
pub enum CameraPathError {
    #[error("there is no such camera path: {}", path.display())]
    NotFound { path: PathBuf },
    #[error("cannot read the camera path: {source}: {}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("unknown camera path format (expected {}): {}", one_of(extensions()), path.display())]
    UnknownFormat { path: PathBuf },
    /// One line for every problem.
    #[error("{}", problems.display(path))]
    Invalid { path: PathBuf, problems: PathProblems },
}

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

fn extensions() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().flat_map(|f| f.extensions).copied()
}

impl CameraPathFormat {
    /// The format with this name, in any case.
    pub fn by_name(name: &str) -> Option<&'static Self> {
        FORMATS.iter().find(|f| f.name.eq_ignore_ascii_case(name))
    }

    /// The format by the extension of a file's name.
    pub fn of_path(path: &Path) -> Option<&'static Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        FORMATS.iter().find(|f| f.extensions.contains(&extension.as_str()))
    }

    /// Reads a camera path in this format.
    ///
    /// # Errors
    /// Up to 20 problems, and how many more there are.
    pub fn read(&self, bytes: &[u8], options: &CameraPathOptions) -> Result<CameraPath, PathProblems> {
        (self.read)(bytes, options)
    }
}

/// Loads a camera path, in the given format or by the file's extension.
///
/// # Errors
/// The file cannot be read, its format is unknown, or its contents are invalid.
pub fn load(
    path: &Path,
    format: Option<&CameraPathFormat>,
    options: &CameraPathOptions,
    files: &Files,
) -> Result<CameraPath, CameraPathError> {
    let owned = || path.to_owned();
    let format = format
        .or_else(|| CameraPathFormat::of_path(path))
        .ok_or_else(|| CameraPathError::UnknownFormat { path: owned() })?;
    let bytes = files.read(path).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => CameraPathError::NotFound { path: owned() },
        _ => CameraPathError::Io { path: owned(), source },
    })?;
    format
        .read(&bytes, options)
        .map_err(|problems| CameraPathError::Invalid {
            path: owned(),
            problems,
        })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_missing_file_is_told_from_one_that_cannot_be_read() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let missing = folder.path().join("path.csv");
        let error = load(&missing, None, &CameraPathOptions::default(), &Files::default()).unwrap_err();
        assert!(matches!(error, CameraPathError::NotFound { .. }));
        assert_eq!(
            error.to_string(),
            format!("there is no such camera path: {}", missing.display())
        );

        let csv = CameraPathFormat::by_name("CSV");
        let error = load(folder.path(), csv, &CameraPathOptions::default(), &Files::default()).unwrap_err();
        assert!(matches!(error, CameraPathError::Io { .. }));
    }

    #[test]
    fn an_unknown_ending_names_the_known_ones() {
        let error = load(
            Path::new("shot.abc"),
            None,
            &CameraPathOptions::default(),
            &Files::default(),
        )
        .unwrap_err();
        assert_eq!(
            error.to_string(),
            "unknown camera path format (expected one of `csv`, `tsv`): shot.abc"
        );
    }

    #[test]
    fn a_file_is_loaded_and_its_problems_bear_its_name() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("Shot.CSV");
        let header = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n";
        fs::write(&path, format!("{header}1,0,0,15,0,0,0\n")).expect("written");
        let loaded = load(&path, None, &CameraPathOptions::default(), &Files::default()).expect("a path");
        assert_eq!(loaded.frames(), 1..=1);

        fs::write(&path, format!("{header}1,abc,0,15,0,0,0\n")).expect("written");
        let error = load(&path, None, &CameraPathOptions::default(), &Files::default()).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("{}:2: eye_x: 'abc' is not a number", path.display())
        );
    }
}
