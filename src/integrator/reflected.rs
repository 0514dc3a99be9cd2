//! Light that surfaces reflect, as blocks of them find it.

use crate::{
    bsdf::Lobe,
    math::{Ray, Rgb, Vec3},
    scene::{FamilyBlock, SampledLight},
};

/// A family's light on the surface of a lane, and what of it leaves towards the viewer, in W m^-2 sr^-1, where anything does:
/// `f_cos` is `f |cos|` of the surface, and `weight` that of multiple importance sampling over the light's density.
#[inline(always)]
pub(super) fn reflected(family: &FamilyBlock, lane: usize, f_cos: Rgb, weight: f32) -> Option<(SampledLight, Rgb)> {
    let (li, is_delta) = family.light.li(lane)?;
    let chosen = family.chosen(lane);
    let l = if is_delta {
        f_cos * li / chosen.pmf
    } else {
        f_cos * li * weight
    };
    (!l.is_black()).then_some((chosen, l))
}

/// Light on a surface.
pub(super) struct ReflectedLight {
    pub chosen: SampledLight,
    /// `f |cos|` of all lobes, and of the diffuse ones.
    pub f_cos: Rgb,
    pub diffuse: Rgb,
    /// The light that leaves towards the viewer, in W m^-2 sr^-1.
    pub l: Rgb,
    pub shadow_ray: Ray,
}

/// The way in which a path goes on from a surface.
pub(super) struct ReflectedPath {
    pub ray: Ray,
    /// The density of its direction, in sr^-1.
    pub pdf: f32,
    /// `f |cos| / pdf` of all lobes, and of the diffuse ones.
    pub weight: Rgb,
    pub diffuse: Rgb,
    pub lobe: Lobe,
    /// The normal for which lights were sampled.
    pub n: Vec3,
}
