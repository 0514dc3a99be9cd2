//! The results of blocks: reflected light and continued paths.

use crate::{
    bsdf::Lobe,
    math::{Ray, Rgb, Vec3},
    scene::{FamilyBlock, SampledLight},
};

/// The light of a family that the surface of a lane reflects to the viewer, in W m^-2 sr^-1, if there is any. `f_cos` is
/// `f |cos|`, and `weight` is the MIS weight over the light's density.
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

/// Direct light on a surface.
pub(super) struct ReflectedLight {
    pub chosen: SampledLight,
    /// `f |cos|` of all lobes, and of the diffuse ones.
    pub f_cos: Rgb,
    pub diffuse: Rgb,
    /// The light that is reflected to the viewer, in W m^-2 sr^-1.
    pub l: Rgb,
    pub shadow_ray: Ray,
}

/// The continuation of a path at a surface.
pub(super) struct ReflectedPath {
    pub ray: Ray,
    /// The density of its direction, in sr^-1.
    pub pdf: f32,
    /// `f |cos| / pdf` of all lobes, and of the diffuse ones.
    pub weight: Rgb,
    pub diffuse: Rgb,
    pub lobe: Lobe,
    /// The normal with which lights were sampled.
    pub n: Vec3,
}
