//! The table of the formats of camera paths, and the loading of a file by its format.

use std::{
    io,
    path::{Path, PathBuf},
};

use super::{
    CameraPathOptions, PathProblem, PathProblems, Source, chan, colmap, csv, format::CameraPathFormat, gltf_nodes,
    opencv, transforms, tum,
};
use crate::{assets::Files, camera::path::CameraPath, value::one_of};

/// All formats. Those with names of files are before others with the same endings.
pub const FORMATS: &[CameraPathFormat] = &[
    csv::FORMAT,
    chan::FORMAT,
    colmap::FORMAT,
    tum::FORMAT,
    transforms::FORMAT,
    gltf_nodes::FORMAT,
    opencv::FORMAT,
];

/// Why there is no camera path.
#[derive(Debug, thiserror::Error)]
pub enum CameraPathError {
    #[error("there is no such camera path: {}", path.display())]
    NotFound { path: PathBuf },
    #[error("cannot read the camera path: {source}: {}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("unknown camera path format (expected {}): {}", one_of(extensions()), path.display())]
    UnknownFormat { path: PathBuf },
    /// The format of a file that is to be written cannot hold the cameras, or there are none.
    #[error("{cause}: {}", path.display())]
    Unfit { cause: String, path: PathBuf },
    /// One line for every problem.
    #[error("{}", problems.display(path))]
    Invalid { path: PathBuf, problems: PathProblems },
}

fn extensions() -> impl Iterator<Item = &'static str> {
    let all = FORMATS
        .iter()
        .enumerate()
        .flat_map(|(i, f)| f.extensions.iter().map(move |e| (i, *e)));
    let is_first = |(i, e): &(usize, &str)| FORMATS[..*i].iter().all(|f| !f.extensions.contains(e));
    all.filter(is_first).map(|(_, e)| e)
}

impl CameraPathFormat {
    /// The format with this name, in any case.
    pub fn by_name(name: &str) -> Option<&'static Self> {
        FORMATS.iter().find(|f| f.name.eq_ignore_ascii_case(name))
    }

    /// The format by a file's name: by its extension, and by the whole name where several formats have that. A folder is a
    /// reconstruction of COLMAP.
    pub fn of_path(path: &Path) -> Option<&'static Self> {
        if path.is_dir() {
            return Self::by_name("colmap");
        }
        let name = path.file_name()?.to_string_lossy();
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        let is_format = |f: &&Self| f.extensions.contains(&extension.as_str());
        let is_name = |f: &&Self| f.names.is_empty() || f.names.contains(&&*name);
        FORMATS.iter().filter(is_format).find(is_name)
    }
}

/// The files that a camera path consists of: itself, or those of a reconstruction.
pub fn files_of(path: &Path) -> Vec<PathBuf> {
    let main = main_file(path);
    let is_binary = main.extension().is_some_and(|ending| ending == "bin");
    match CameraPathFormat::of_path(&main) {
        Some(format) if !format.names.is_empty() => colmap::file_names(is_binary)
            .map(|name| main.with_file_name(name))
            .into(),
        _ => vec![main],
    }
}

/// The file that a path names: of a folder, the images of its reconstruction.
fn main_file(path: &Path) -> PathBuf {
    if !path.is_dir() {
        return path.to_owned();
    }
    let names = [true, false].map(|is_binary| path.join(colmap::file_names(is_binary)[0]));
    let [binary, text] = names;
    if binary.is_file() { binary } else { text }
}

/// Loads a camera path, in the given format or by the file's name.
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
    let path = &if format.names.is_empty() {
        path.to_owned()
    } else {
        main_file(path)
    };
    let owned = || path.to_owned();
    let bytes = files.read(path).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => CameraPathError::NotFound { path: owned() },
        _ => CameraPathError::Io { path: owned(), source },
    })?;
    if bytes.iter().all(u8::is_ascii_whitespace) {
        let problems = PathProblem::of_file("the file is empty").into();
        return Err(CameraPathError::Invalid {
            path: owned(),
            problems,
        });
    }
    let source = Source {
        path,
        bytes: &bytes,
        options,
        files,
    };
    format.read(&source).map_err(|problems| CameraPathError::Invalid {
        path: owned(),
        problems,
    })
}
