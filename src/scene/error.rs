//! Errors of building a scene, with the object at fault.

use std::fmt;

use crate::geometry::BuildError;

/// The reason why a scene was not built.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneBuildError {
    pub cause: BuildError,
    /// The name of the object at fault, if there is one.
    pub object: Option<String>,
    /// The file that its geometry comes from.
    pub asset: Option<String>,
}

impl fmt::Display for SceneBuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(object) = &self.object {
            write!(f, "object `{object}`")?;
            if let Some(asset) = &self.asset {
                write!(f, " of {asset}")?;
            }
            f.write_str(": ")?;
        }
        self.cause.fmt(f)
    }
}

impl std::error::Error for SceneBuildError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.cause)
    }
}
