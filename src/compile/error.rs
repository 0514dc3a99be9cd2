//! Errors of compilation.

use std::path::PathBuf;

use super::asset_errors::{AssetErrors, FileError};
use crate::{
    assets::{AssetError, OverBudget},
    describe::{Diagnostics, SceneDesc},
    scene::SceneBuildError,
};

/// Why compilation failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("{0}")]
    Invalid(Diagnostics),
    #[error("{0}")]
    Assets(AssetErrors),
    #[error("{cause}: {}", path.display())]
    Build {
        cause: SceneBuildError,
        /// The scene's file.
        path: PathBuf,
    },
    #[error("--normalise: the model is {size:?} m large, too small to be scaled to a common size: {}", path.display())]
    TooSmall { size: f64, path: PathBuf },
    #[error("{cause}: {}", path.display())]
    Memory {
        cause: OverBudget,
        /// The scene's file.
        path: PathBuf,
    },
}

impl Error {
    /// The files of this scene that were not loaded.
    pub(super) fn assets(errors: Vec<FileError>, desc: &SceneDesc) -> Self {
        Self::Assets(AssetErrors::of_scene(errors, desc, None))
    }
}

impl From<AssetError> for Error {
    fn from(error: AssetError) -> Self {
        Self::Assets(AssetErrors::from(error))
    }
}
