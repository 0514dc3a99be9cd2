//! Serialization of values as texts, for events and figures.

use std::{fmt::Display, path::Path};

use serde::Serializer;

/// Serializes a path as a text; bytes that are not UTF-8 are replaced.
pub(super) fn path<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&path.display())
}

/// Serializes a value as it is displayed.
pub(super) fn text<S: Serializer>(value: &impl Display, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(value)
}
