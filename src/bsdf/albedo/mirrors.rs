//! Facets whose albedo is known where they reflect all light.

use crate::{bsdf::microfacet::Facets, math::Vec3};

/// Facets that reflect all light.
pub trait MirrorFacets: Facets {
    /// The place of facets in the tables of albedos.
    type Albedo: Copy + std::fmt::Debug;

    fn albedo(&self) -> Self::Albedo;

    /// The albedo of these facets, which `albedo` is the place of, seen from `wo`; not less than the truth.
    fn mirrors(&self, albedo: &Self::Albedo, wo: Vec3) -> f32;
}
