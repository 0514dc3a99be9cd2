//! Shading frames: the shading normal of a surface from its mesh, its normal map and the viewer.
//!
//! Interpolated and mapped normals allow cases that no real surface has: a viewer behind the normal, and mirror directions
//! below the surface. Normals are adjusted so that neither happens.

use super::{Scene, SurfaceInteraction, interaction::reflecting_normal};
use crate::{
    bsdf::BsdfKind,
    material::{Material, NormalMap, Relief, SurfaceOfHeights},
    math::{Frame, Vec3},
};

/// The frame of a surface, and the plane of its mesh.
pub struct ShadingFrame {
    /// A frame around the normal on the viewer's side, or as authored if the surface transmits.
    pub frame: Frame,
    /// The normal without the normal map, on the viewer's side.
    pub base: Vec3,
    /// The normal of a clear coat in `frame`, if it differs from that of `frame`.
    pub coat: Option<Vec3>,
    /// Whether the second axis of `frame` is opposite to the bitangent, for BSDFs that depend on it.
    pub opposes_bitangent: bool,
}

impl ShadingFrame {
    /// Returns the BSDF adapted to this frame; `None` if it needs no change.
    #[inline(always)]
    pub fn adapt<B: BsdfKind + Copy>(&self, bsdf: &B) -> Option<B> {
        if self.coat.is_none() && !self.opposes_bitangent {
            return None;
        }
        let mut adapted = *bsdf;
        if let Some(normal) = self.coat {
            adapted.set_coat_normal(normal);
        }
        if self.opposes_bitangent {
            adapted.mirror_bitangent();
        }
        Some(adapted)
    }
}

/// The shading normal that the map of the surface's material turns, on the side of the geometric one; `None` without a map.
#[inline(always)]
pub fn mapped_normal(scene: &Scene, surface: &SurfaceInteraction) -> Option<Vec3> {
    let map = scene.shading.normal_map(surface.material)?;
    Some(turned_frame(scene, surface, Some(map), false).n)
}

#[inline(always)]
pub fn shading_frame(
    scene: &Scene,
    surface: &SurfaceInteraction,
    material: &Material,
    bsdf: &impl BsdfKind,
) -> ShadingFrame {
    let is_smooth = surface.ns != surface.ng;
    let map = scene.shading.normal_map(surface.material);
    let frame = if map.is_some() || bsdf.reads_tangent() || bsdf.mirrors() && is_smooth {
        let Frame { s, t, n } = turned_frame(scene, surface, map, bsdf.mirrors());
        // Copied by component, so that the compiler keeps the frame in registers.
        let [s, t, n] = [s, t, n].map(|v| Vec3::new(v.x, v.y, v.z));
        Frame { s, t, n }
    } else {
        surface.frame
    };
    let frame = if is_smooth && bsdf.transmits() {
        let by = |n: Vec3| bsdf.reflects_totally(n.dot(surface.wo));
        // Otherwise light could not leave a smooth body again.
        if by(frame.n) && !by(surface.ng) {
            Frame::from_normal(surface.ng)
        } else {
            frame
        }
    } else {
        frame
    };
    let front = surface.viewed_side();
    let sign = if bsdf.transmits() { 1.0 } else { front };
    let frame = Frame {
        s: frame.s,
        t: frame.t * sign,
        n: frame.n * sign,
    };
    let coat = if bsdf.has_coat() {
        coat_normal(scene, surface, material).map(|n| frame.to_local(n * sign))
    } else {
        None
    };
    ShadingFrame {
        frame,
        base: surface.viewed_normal(),
        coat,
        opposes_bitangent: bsdf.reads_bitangent() && is_mirrored(surface, &frame, sign),
    }
}

/// Whether the bitangent of the surface is opposite to the second axis of `frame`, whose normal is the authored one times `sign`.
fn is_mirrored(surface: &SurfaceInteraction, frame: &Frame, sign: f32) -> bool {
    match surface.tangent.w {
        0.0 => frame.t.dot(surface.dpdv) < 0.0,
        side => side * sign < 0.0,
    }
}

/// The normal of a clear coat as authored; `None` if it is that of the surface.
#[inline(never)]
fn coat_normal(scene: &Scene, surface: &SurfaceInteraction, material: &Material) -> Option<Vec3> {
    let own = material.coat_normal(&scene.textures(), &surface.texture);
    let n = own.or_else(|| scene.shading.given_normal_map(surface.material).map(|_| Vec3::Z))?;
    let base = tangent_frame(surface, reflecting(surface, surface.frame.n, surface.ng));
    let mapped = from_tangent_space(surface, &base, n).normalize_or(base.n);
    Some(reflecting(surface, mapped, base.n))
}

/// Applies [`reflecting_normal`] to `n` on the viewer's side.
fn reflecting(surface: &SurfaceInteraction, n: Vec3, ng: Vec3) -> Vec3 {
    let front = if surface.ng.dot(surface.wo) >= 0.0 { 1.0 } else { -1.0 };
    reflecting_normal(n * front, ng * front, surface.wo) * front
}

/// Transforms a vector from the tangent space of `base`, whose second axis is the bitangent.
fn from_tangent_space(surface: &SurfaceInteraction, base: &Frame, v: Vec3) -> Vec3 {
    let side = if is_mirrored(surface, base, 1.0) { -1.0 } else { 1.0 };
    base.to_world(Vec3::new(v.x, side * v.y, v.z))
}

/// A frame around the shading normal or the mapped normal, turned to the viewer; the first axis is the tangent. With `mirrors`
/// the normal is also adjusted so that the mirror direction is above the surface.
#[inline(never)]
fn turned_frame(scene: &Scene, surface: &SurfaceInteraction, map: Option<&NormalMap>, mirrors: bool) -> Frame {
    let authored = if mirrors {
        reflecting(surface, surface.frame.n, surface.ng)
    } else {
        surface.frame.n
    };
    let base = tangent_frame(surface, authored);
    let Some(map) = map else {
        return base;
    };
    let textures = scene.textures();
    let mapped = match map {
        NormalMap::Normals(map) => from_tangent_space(surface, &base, map.normal(&textures, &surface.texture)),
        NormalMap::Heights(map) => {
            let lifted = SurfaceOfHeights {
                dpdu: surface.dpdu,
                dpdv: surface.dpdv,
                axis: surface.height_axis,
            };
            let Relief { slope, along } = map.relief(&textures, &surface.texture, &lifted);
            // The slope on a smooth surface is in the plane of the triangle, not perpendicular to the normal.
            authored * along - (slope - authored * authored.dot(slope))
        }
    };
    let mapped = mapped.normalize_or(authored);
    // Needed without mirrors too: it also turns the normal to the viewer.
    tangent_frame(surface, reflecting(surface, mapped, authored))
}

/// A frame around `n` whose first axis is the tangent.
fn tangent_frame(surface: &SurfaceInteraction, n: Vec3) -> Frame {
    let along = if surface.tangent.w == 0.0 {
        surface.dpdu
    } else {
        surface.tangent.truncate()
    };
    let s = along - n * n.dot(along);
    match s.try_normalize() {
        Some(s) => Frame { s, t: n.cross(s), n },
        None => Frame::from_normal(n),
    }
}
