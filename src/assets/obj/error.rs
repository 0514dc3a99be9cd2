//! Why an OBJ model was not loaded.

use std::{
    io,
    path::{Path, PathBuf},
};

use crate::assets::{files::is_refused, model_format::ModelError};

/// Why an OBJ file was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum ObjError {
    #[error("cannot read model: {source}: {}", path.display())]
    Read { source: io::Error, path: PathBuf },
    #[error("line {line}: {cause}: {}", path.display())]
    Line { line: usize, cause: String, path: PathBuf },
    #[error("broken model: {cause}: {}", path.display())]
    Broken { cause: String, path: PathBuf },
    #[error("the model {} names a file outside of its folder (--allow-outside permits that): {}", path.display(), file.display())]
    Outside { file: PathBuf, path: PathBuf },
}

impl ModelError for ObjError {
    fn path(&self) -> &Path {
        let (Self::Read { path, .. }
        | Self::Line { path, .. }
        | Self::Broken { path, .. }
        | Self::Outside { path, .. }) = self;
        path
    }

    fn is_missing(&self) -> bool {
        matches!(self, Self::Read { source, .. } if !is_refused(source))
    }
}
