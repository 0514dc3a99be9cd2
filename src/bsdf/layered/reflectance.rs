//! The reflectance of clear facets under a film.

use crate::math::Rgb;

/// How the reflectance of a clear facet differs from Fresnel's: it is scaled, and a part of the
/// rest is reflected too.
pub(super) struct ClearReflectance {
    pub scale: Rgb,
    pub more: Rgb,
}

impl ClearReflectance {
    /// Of what is not clear.
    pub const NONE: Self = Self {
        scale: Rgb::BLACK,
        more: Rgb::BLACK,
    };
}
