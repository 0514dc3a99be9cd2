//! Surface interactions: the surface at a hit, and the rays that leave it.

use super::ObjectId;
use crate::{
    material::MaterialId,
    math::{Frame, Ray, Vec2, Vec3, float},
    texture::TexturePoint,
};

/// The smallest cosine of a footprint; the footprint of a more grazing ray would be unbounded.
const MIN_COS: f32 = 1.0 / 64.0;

/// The surface at a hit, in world space. Normals are as authored.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInteraction {
    /// In lengths of the ray's direction.
    pub t: f32,
    pub p: Vec3,
    /// The origins of rays that leave on the side of `ng` and on the other side: `p` offset by its
    /// error bound.
    pub ray_origins: [Vec3; 2],
    /// Unit geometric normal.
    pub ng: Vec3,
    /// Unit shading normal.
    pub ns: Vec3,
    /// About the shading normal; at the rim of a smooth mesh, where that points away from a viewer
    /// in front or the other way round, about the geometric one. Its first axis points anywhere.
    pub frame: Frame,
    /// The derivative of `p` with respect to `u`; zero without texture coordinates, and unknown for a
    /// material that is the same everywhere.
    pub dpdu: Vec3,
    pub dpdv: Vec3,
    /// Unit direction back along the ray.
    pub wo: Vec3,
    /// The place in the object's own space; of one whose material is the same everywhere `uv` alone
    /// is known.
    pub texture: TexturePoint,
    pub object: ObjectId,
    pub material: MaterialId,
}

/// The geometry of a hit, independent of the viewer.
#[derive(Clone, Copy, Debug)]
pub(super) struct HitGeometry {
    pub p: Vec3,
    /// Bound on the absolute error of each coordinate of `p`.
    pub p_error: Vec3,
    /// Unit geometric normal.
    pub ng: Vec3,
    /// In the direction of the shading normal; zero where that is the geometric one.
    pub smooth: Vec3,
}

/// The part of an interaction that depends on the viewer.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadingView {
    pub wo: Vec3,
    pub ns: Vec3,
    pub ray_origins: [Vec3; 2],
    pub frame: Frame,
}

impl HitGeometry {
    /// Computes the shading view of a ray along `d`.
    #[inline(always)]
    pub fn shading_view(&self, d: Vec3) -> ShadingView {
        let wo = -d.normalize();
        let ns = self.smooth.normalize_or(self.ng);
        let authored = if is_consistent_normal(ns, self.ng, wo) {
            ns
        } else {
            self.ng
        };
        ShadingView {
            wo,
            ns,
            ray_origins: float::offset_origins(self.p, self.p_error, self.ng),
            frame: Frame::from_normal(authored),
        }
    }
}

/// Whether a viewer in the direction `wo` is on the same side by `n` as by the geometric normal.
#[inline(always)]
fn is_consistent_normal(n: Vec3, ng: Vec3, wo: Vec3) -> bool {
    (n.dot(wo) > 0.0) == (ng.dot(wo) >= 0.0)
}

impl SurfaceInteraction {
    /// An interaction whose fields are not set.
    pub(super) fn unset() -> Self {
        Self {
            t: 0.0,
            p: Vec3::ZERO,
            ray_origins: [Vec3::ZERO; 2],
            ng: Vec3::ZERO,
            ns: Vec3::ZERO,
            frame: Frame {
                s: Vec3::ZERO,
                t: Vec3::ZERO,
                n: Vec3::ZERO,
            },
            dpdu: Vec3::ZERO,
            dpdv: Vec3::ZERO,
            wo: Vec3::ZERO,
            texture: TexturePoint::new(Vec3::ZERO, Vec3::Y),
            object: ObjectId(0),
            material: MaterialId(0),
        }
    }

    /// Sets the geometry and the shading view.
    #[inline(always)]
    pub(super) fn set_geometry(&mut self, geometry: &HitGeometry, view: &ShadingView) {
        (self.p, self.ng) = (geometry.p, geometry.ng);
        (self.wo, self.ns) = (view.wo, view.ns);
        (self.ray_origins, self.frame) = (view.ray_origins, view.frame);
    }

    /// Whether the viewer is on the same side by `n` as by the geometric normal.
    #[inline]
    pub fn is_consistent_normal(&self, n: Vec3) -> bool {
        is_consistent_normal(n, self.ng, self.wo)
    }

    /// Sets the footprint for texture filtering, from the width of the ray cone in m.
    ///
    /// The cone meets the surface in an ellipse, stretched by 1/cos along the projection of the
    /// ray.
    pub fn set_footprint(&mut self, width: f32) {
        let (u, v) = (self.dpdu, self.dpdv);
        let area = u.cross(v);
        let area2 = area.length_squared();
        let cos = self.ng.dot(self.wo).abs().max(MIN_COS);
        let across = match self.ng.cross(self.wo).try_normalize() {
            Some(across) => across,
            None => Frame::from_normal(self.ng).s,
        };
        let along = self.ng.cross(across);
        let in_uv = |d: Vec3| Vec2::new(d.cross(v).dot(area), u.cross(d).dot(area)) / area2;
        // Where the parameters do not span the surface, as at a pole, nothing is known.
        self.texture.footprint = if area2 > 0.0 {
            [in_uv(across * width), in_uv(along * (width / cos))]
        } else {
            [Vec2::ZERO; 2]
        };
    }

    /// The curvature as seen by the viewer, in m^-1; negative where the surface is concave.
    pub fn signed_curvature(&self) -> f32 {
        let local = self.texture.curvature;
        if local == 0.0 {
            return 0.0;
        }
        let larger = self.dpdu.length_squared() / self.texture.dpdu.length_squared();
        let world = if larger.is_finite() && larger > 0.0 {
            local / larger.sqrt()
        } else {
            local
        };
        if self.ng.dot(self.wo) < 0.0 { -world } else { world }
    }

    /// The ray that leaves along the unit direction `w`.
    #[inline(always)]
    pub fn spawn_ray(&self, w: Vec3) -> Ray {
        Ray::new(self.origin(w), w)
    }

    /// The ray towards a light `distance` away along the unit direction `w`, up to the light.
    #[inline(always)]
    pub fn shadow_ray(&self, w: Vec3, distance: f32) -> Ray {
        let o = self.origin(w);
        if distance.is_finite() {
            // From the moved origin to the same point: neither short of the light nor past it.
            let d = self.p + w * distance - o;
            Ray::segment(o, d, 1.0)
        } else {
            Ray::new(o, w)
        }
    }

    #[inline(always)]
    fn origin(&self, w: Vec3) -> Vec3 {
        let ([above, below], is_below) = (self.ray_origins, w.dot(self.ng) < 0.0);
        // Nobody can predict the side, so it is not branched on.
        let either = |above: f32, below: f32| if is_below { below } else { above };
        Vec3::new(
            either(above.x, below.x),
            either(above.y, below.y),
            either(above.z, below.z),
        )
    }
}
