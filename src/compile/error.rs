//! Errors of compilation.

use std::path::PathBuf;

use crate::{
    assets::{AssetError, OverBudget},
    describe::Diagnostics,
    scene::SceneBuildError,
};

/// Why compilation failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("{0}")]
    Invalid(Diagnostics),
    #[error("{}", lines(.0))]
    Assets(Vec<AssetError>),
    #[error("{cause}: {}", path.display())]
    Build {
        cause: SceneBuildError,
        /// The scene's file.
        path: PathBuf,
    },
    #[error("{cause}: {}", path.display())]
    Memory {
        cause: OverBudget,
        /// The scene's file.
        path: PathBuf,
    },
}

impl From<AssetError> for Error {
    fn from(error: AssetError) -> Self {
        Self::Assets(vec![error])
    }
}

fn lines(errors: &[AssetError]) -> String {
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}
