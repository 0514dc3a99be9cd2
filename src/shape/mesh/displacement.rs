//! The description of a displacement.

use serde::Deserialize;

use crate::value::{Finite, ScalarSource, Spanned};

/// A displacement of vertices along their normals: `scale` times the height less `midlevel`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DisplacementDesc {
    /// A number, or a texture by the mesh's texture coordinates.
    pub height: Spanned<ScalarSource>,
    /// In the unit of the model.
    #[serde(default = "Finite::one")]
    pub scale: Finite,
    #[serde(default = "zero")]
    pub midlevel: Finite,
}

fn zero() -> Finite {
    Finite(0.0)
}
