//! Why a description became no scene.

use crate::{assets::AssetError, describe::Diagnostics, geometry::BuildError};

/// Why a description became no scene.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("{0}")]
    Invalid(Diagnostics),
    #[error("{}", lines(.0))]
    Assets(Vec<AssetError>),
    #[error(transparent)]
    Build(#[from] BuildError),
}

fn lines(errors: &[AssetError]) -> String {
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}
