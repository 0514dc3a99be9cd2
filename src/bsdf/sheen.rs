//! Sheen of cloth and dust: fibres scatter light at grazing angles.
//!
//! Normals are distributed as a power of the sine of their angle, without masking but for the
//! smooth rim term. Where more light than arrives would leave, at grazing angles, the lobe is
//! scaled down to what arrives.
//!
//! Source: Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF", Sony Pictures
//! Imageworks, 2017; for the rim term Neubelt and Pettineo, "Crafting a Next-Gen Material Pipeline
//! for The Order: 1886", SIGGRAPH 2013 course.

use std::f32::consts::PI;

use super::albedo;
use crate::math::{Vec3, exponential};

/// The least roughness: below it the lobe is a rim too thin to see.
pub(super) const MIN_ROUGHNESS: f32 = 0.15;

/// `f |cos|` of a white sheen, before it is scaled down where it would send back more light than
/// arrives.
pub(super) fn raw_f_cos(roughness: f32, wo: Vec3, wi: Vec3) -> f32 {
    let Some(h) = (wo + wi).try_normalize() else { return 0.0 };
    let roughness = roughness.max(MIN_ROUGHNESS);
    let power = 1.0 / (roughness * roughness);
    let sin2 = (h.x * h.x + h.y * h.y).min(1.0);
    let density = (2.0 + power) * exponential::pow(sin2, 0.5 * power) / (2.0 * PI);
    let rim = 4.0 * (wo.z + wi.z - wo.z * wi.z);
    if rim <= 0.0 { 0.0 } else { density * wi.z / rim }
}

/// `f |cos|` of a white sheen, for directions above the surface.
pub fn f_cos(roughness: f32, wo: Vec3, wi: Vec3) -> f32 {
    raw_f_cos(roughness, wo, wi) / albedo::raw_sheen(roughness, wo.z).max(1.0)
}

/// The albedo of a white sheen.
pub fn albedo(roughness: f32, cos: f32) -> f32 {
    albedo::raw_sheen(roughness, cos).min(1.0)
}
