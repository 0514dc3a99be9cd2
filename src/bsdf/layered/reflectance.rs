//! The reflectance of clear facets under a film.

use crate::math::Rgb;

/// The difference between the reflectance of a clear facet and Fresnel's: a scale, and a part of
/// the rest that is reflected too.
pub(super) struct ClearReflectance {
    pub scale: Rgb,
    pub more: Rgb,
}

impl ClearReflectance {
    /// The reflectance of a base that is not clear.
    pub const NONE: Self = Self {
        scale: Rgb::BLACK,
        more: Rgb::BLACK,
    };
}
