//! Why a file of a scene was not loaded.

use std::path::{Path, PathBuf};

use super::{
    OverBudget, ies::IesError, image::ImageError, model_format::ModelError, model_formats,
    subdivision::SubdivisionProblem,
};

/// Why a file was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum AssetError {
    #[error("{cause}: {}", path.display())]
    Memory { cause: OverBudget, path: PathBuf },
    #[error(transparent)]
    Image(#[from] ImageError),
    #[error(transparent)]
    Ies(#[from] IesError),
    #[error("{0}")]
    Model(Box<dyn ModelError>),
    #[error("unknown model format ({}): {}", model_formats::Unknown(path), path.display())]
    UnknownModel { path: PathBuf },
    /// The scene that is written for a model names it, in UTF-8.
    #[error("the name of the model is not UTF-8, rename the file: {}", path.display())]
    NotUtf8 { path: PathBuf },
    #[error("the model has no triangles: {}", path.display())]
    NoTriangles { path: PathBuf },
    #[error("broken material of a model: {cause}: {}", path.display())]
    Material { cause: String, path: PathBuf },
    #[error("the model has no camera `{name}` (it has {known}): {}", path.display())]
    NoCamera { name: String, known: String, path: PathBuf },
    #[error("only glTF files have scenes: {}", path.display())]
    NoScenes { path: PathBuf },
    #[error("only glTF files have material variants: {}", path.display())]
    NoVariants { path: PathBuf },
    #[error("only glTF files have lights: {}", path.display())]
    NoLights { path: PathBuf },
    #[error("only glTF files have animations: {}", path.display())]
    NoAnimations { path: PathBuf },
    #[error("broken light of a model: {cause}: {}", path.display())]
    Light { cause: String, path: PathBuf },
    #[error("{cause}: {}", path.display())]
    Subdivision {
        cause: Box<SubdivisionProblem>,
        path: PathBuf,
    },
    #[error("{}: {}", path.display(), losses.join("; "))]
    Incomplete { losses: Vec<String>, path: PathBuf },
    #[error("{triangles} triangles are more than the {limit} that there can be: {}", path.display())]
    TooManyTriangles { triangles: u64, limit: u64, path: PathBuf },
}

impl AssetError {
    /// The messages: one for each loss of an incomplete model.
    pub fn messages(&self) -> Vec<String> {
        match self {
            Self::Incomplete { losses, path } => losses
                .iter()
                .map(|loss| format!("{}: {loss}", path.display()))
                .collect(),
            other => vec![other.to_string()],
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        match self {
            Self::Image(e) => e.path(),
            Self::Ies(e) => e.path(),
            Self::Model(e) => e.path(),
            Self::UnknownModel { path }
            | Self::NotUtf8 { path }
            | Self::NoTriangles { path }
            | Self::NoScenes { path }
            | Self::NoVariants { path }
            | Self::NoLights { path }
            | Self::NoAnimations { path }
            | Self::Light { path, .. }
            | Self::NoCamera { path, .. }
            | Self::Subdivision { path, .. }
            | Self::Incomplete { path, .. }
            | Self::Material { path, .. }
            | Self::TooManyTriangles { path, .. }
            | Self::Memory { path, .. } => path,
        }
    }

    /// Whether what a flag or a scene file chooses of a model does not fit it.
    pub fn is_choice(&self) -> bool {
        matches!(self, Self::Model(e) if e.is_choice())
    }

    /// Whether a file could not be read at all, rather than understood.
    pub fn is_missing(&self) -> bool {
        match self {
            Self::Image(e) => e.is_missing(),
            Self::Ies(e) => e.is_missing(),
            Self::Model(e) => e.is_missing(),
            Self::UnknownModel { .. }
            | Self::NotUtf8 { .. }
            | Self::NoTriangles { .. }
            | Self::NoScenes { .. }
            | Self::NoVariants { .. }
            | Self::NoLights { .. }
            | Self::NoAnimations { .. }
            | Self::Light { .. }
            | Self::NoCamera { .. }
            | Self::Subdivision { .. }
            | Self::Incomplete { .. }
            | Self::Material { .. }
            | Self::TooManyTriangles { .. }
            | Self::Memory { .. } => false,
        }
    }
}
