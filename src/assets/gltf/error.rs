//! Why a glTF asset was not loaded.

use std::{
    io,
    path::{Path, PathBuf},
};

use crate::{
    assets::{files::is_refused, model_format::ModelError},
    value::UnknownName,
};

/// Why a glTF asset was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum GltfError {
    #[error("cannot read model: {source}: {}", path.display())]
    Read { source: io::Error, path: PathBuf },
    #[error("cannot read a file that the model {} needs: {source}: {}", path.display(), file.display())]
    Missing {
        source: io::Error,
        file: PathBuf,
        path: PathBuf,
    },
    #[error("broken model: {cause}: {}", path.display())]
    Broken { cause: String, path: PathBuf },
    #[error("{cause}: {}", path.display())]
    UnknownName { cause: UnknownName, path: PathBuf },
    #[error("{cause}: {}", path.display())]
    Conflict { cause: String, path: PathBuf },
    #[error("unsupported model: {what}: {}", path.display())]
    Unsupported { what: String, path: PathBuf },
}

impl ModelError for GltfError {
    fn path(&self) -> &Path {
        let (Self::Read { path, .. }
        | Self::Missing { path, .. }
        | Self::Broken { path, .. }
        | Self::UnknownName { path, .. }
        | Self::Conflict { path, .. }
        | Self::Unsupported { path, .. }) = self;
        path
    }

    fn is_missing(&self) -> bool {
        matches!(self, Self::Read { source, .. } | Self::Missing { source, .. } if !is_refused(source))
    }

    fn is_choice(&self) -> bool {
        matches!(self, Self::UnknownName { .. } | Self::Conflict { .. })
    }
}

/// An error inside a glTF file.
#[derive(Debug, thiserror::Error)]
pub(super) enum GltfProblem {
    #[error("{0}")]
    Broken(String),
    #[error("{0}")]
    UnknownName(UnknownName),
    /// Choices that exclude each other.
    #[error("{0}")]
    Conflict(String),
    #[error("{0}")]
    Unsupported(String),
    #[error("{source}")]
    Missing { source: io::Error, file: PathBuf },
}

impl GltfProblem {
    pub fn broken(cause: impl ToString) -> Self {
        Self::Broken(cause.to_string())
    }

    pub fn unsupported(what: String) -> Self {
        Self::Unsupported(what)
    }

    pub fn refused(uri: &str, why: &str) -> Self {
        let shown: String = uri.chars().take(80).collect();
        Self::Broken(format!("the URI '{shown}' is refused: {why}"))
    }

    /// Adds the place of the error.
    pub fn within(self, place: &str) -> Self {
        match self {
            Self::Broken(cause) => Self::Broken(format!("{place}: {cause}")),
            other => other,
        }
    }

    pub fn at(self, path: &Path) -> GltfError {
        let path = path.to_owned();
        match self {
            Self::Broken(cause) => GltfError::Broken { cause, path },
            Self::UnknownName(cause) => GltfError::UnknownName { cause, path },
            Self::Conflict(cause) => GltfError::Conflict { cause, path },
            Self::Unsupported(what) => GltfError::Unsupported { what, path },
            Self::Missing { source, file } => GltfError::Missing { source, file, path },
        }
    }
}
