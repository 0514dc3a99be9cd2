//! Shading frames: the normal by which a surface is shaded, from its mesh, its normal map and the viewer.
//!
//! Normals that are not those of the triangles make directions possible that no real surface has: a viewer behind the normal,
//! and mirror images below the surface. Normals are turned so that neither happens.

use super::{Scene, SurfaceInteraction, interaction::reflecting_normal};
use crate::{
    bsdf::BsdfKind,
    material::{Material, NormalMap},
    math::{Frame, Vec3},
};

/// The frame of a surface, and the plane of its mesh.
pub struct ShadingFrame {
    /// About the normal on the side of the viewer, or as authored where light passes through.
    pub frame: Frame,
    /// The normal without a normal map, on the side of the viewer.
    pub base: Vec3,
}

#[inline(always)]
pub fn shading_frame(
    scene: &Scene,
    surface: &SurfaceInteraction,
    material: &Material,
    bsdf: &impl BsdfKind,
) -> ShadingFrame {
    let is_smooth = surface.ns != surface.ng;
    let frame = if material.normal_map().is_some() || bsdf.reads_tangent() || bsdf.mirrors() && is_smooth {
        let Frame { s, t, n } = turned_frame(scene, surface, material, bsdf.mirrors());
        // Number by number: what a call has left in memory as a whole would keep the frame there.
        let [s, t, n] = [s, t, n].map(|v| Vec3::new(v.x, v.y, v.z));
        Frame { s, t, n }
    } else {
        surface.frame
    };
    let frame = if is_smooth && bsdf.transmits() {
        let by = |n: Vec3| bsdf.reflects_totally(n.dot(surface.wo));
        // A smooth body would hold light that entered it: its triangles let it out.
        if by(frame.n) && !by(surface.ng) {
            Frame::from_normal(surface.ng)
        } else {
            frame
        }
    } else {
        frame
    };
    let front = if surface.ng.dot(surface.wo) >= 0.0 { 1.0 } else { -1.0 };
    let sign = if bsdf.transmits() { 1.0 } else { front };
    ShadingFrame {
        frame: Frame {
            s: frame.s,
            t: frame.t * sign,
            n: frame.n * sign,
        },
        base: surface.frame.n * front,
    }
}

/// A frame about the shading normal, or about the one that a map tells, turned to the viewer; its first axis follows the
/// texture's. `mirrors` tells whether the mirror image of the viewer is to be above the surface.
#[inline(never)]
fn turned_frame(scene: &Scene, surface: &SurfaceInteraction, material: &Material, mirrors: bool) -> Frame {
    let front = if surface.ng.dot(surface.wo) >= 0.0 { 1.0 } else { -1.0 };
    let authored = if mirrors {
        reflecting_normal(surface.frame.n * front, surface.ng * front, surface.wo) * front
    } else {
        surface.frame.n
    };
    let base = tangent_frame(surface, authored);
    let Some(map) = material.normal_map() else {
        return base;
    };
    let textures = scene.textures();
    let mapped = match map {
        NormalMap::Normals(map) => {
            let n = map.normal(&textures, &surface.texture);
            let handed = match surface.tangent.w {
                0.0 => base.t.dot(surface.dpdv) < 0.0,
                side => side < 0.0,
            };
            base.to_world(Vec3::new(n.x, if handed { -n.y } else { n.y }, n.z))
        }
        NormalMap::Heights(map) => {
            let slope = map.gradient(&textures, &surface.texture, surface.dpdu, surface.dpdv);
            // Of a smooth surface the slope is in the plane of the triangle, not in that of the normal.
            authored - (slope - authored * authored.dot(slope))
        }
    };
    let mapped = mapped.normalize_or(authored);
    // Also without a mirror: its image is above the surface only where the viewer is in front of the normal.
    let n = reflecting_normal(mapped * front, authored * front, surface.wo) * front;
    tangent_frame(surface, n)
}

/// A frame about `n` whose first axis follows the texture's.
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
