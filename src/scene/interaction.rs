//! Surface interactions: the surface at a hit, and the rays that leave it.

use super::ObjectId;
use crate::{
    material::MaterialId,
    math::{Frame, Ray, Vec2, Vec3, Vec4, float},
    texture::{SharedFootprint, TexturePoint},
};

/// The smallest cosine of a footprint; the footprint of a more grazing ray would be unbounded.
const MIN_COS: f32 = 1.0 / 64.0;

/// The least cosine between the surface's normal and a mirror image, unless the viewer is nearer to the surface.
const MIN_REFLECTED_COS: f32 = 0.01;

/// The least cosine between a shading normal and the viewer, so that the viewer is on its side.
const MIN_VIEW_COS: f32 = 1e-3;

/// The surface at a hit, in world space. Normals are as authored.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInteraction {
    /// The ray parameter, in lengths of the ray's direction.
    pub t: f32,
    pub p: Vec3,
    /// The origins of rays that leave on the side of `ng` and on the other side: `p` offset by its
    /// error bound.
    pub ray_origins: [Vec3; 2],
    /// The vector from `p` to the curved surface that the triangles of a smooth mesh approximate, on the side of the viewer, see
    /// [`triangle::lift`](crate::shape::triangle::lift). Zero for other surfaces.
    pub lift: Vec3,
    /// Unit geometric normal.
    pub ng: Vec3,
    /// Unit shading normal.
    pub ns: Vec3,
    /// A frame around the shading normal on the side of `ng`. At the silhouette of a smooth mesh, where shading and geometric
    /// normal disagree about the viewer's side, the normal is turned to the viewer. The first axis is arbitrary.
    pub frame: Frame,
    /// The derivative of `p` with respect to `u`; zero without texture coordinates and for constant materials.
    pub dpdu: Vec3,
    pub dpdv: Vec3,
    /// The mesh's tangent for normal maps, with 1 or -1 for the side of the bitangent; zero if the mesh has none.
    pub tangent: Vec4,
    /// Unit direction back along the ray.
    pub wo: Vec3,
    /// The image in the scene of the unit normal in the object's own space, along which a unit of height lifts the surface.
    /// Unspecified for constant materials, and in scenes whose materials have no heights.
    pub height_axis: Vec3,
    /// The texture point, in the object's own space; for constant materials only `uv` and the curvature are set.
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
    /// The direction of the shading normal; zero if it is the geometric normal.
    pub smooth: Vec3,
    /// See [`SurfaceInteraction::lift`].
    pub lift: Vec3,
}

/// The curved surface that a triangle of a smooth mesh approximates.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SmoothSurface {
    /// See [`HitGeometry::smooth`].
    pub normal: Vec3,
    /// See [`SurfaceInteraction::lift`].
    pub lift: Vec3,
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
    /// Geometry whose shading normal is the geometric one.
    #[inline(always)]
    pub fn flat(p: Vec3, p_error: Vec3, ng: Vec3) -> Self {
        Self {
            p,
            p_error,
            ng,
            smooth: Vec3::ZERO,
            lift: Vec3::ZERO,
        }
    }

    /// Computes the shading view of a ray along `d`.
    #[inline(always)]
    pub fn shading_view(&self, d: Vec3) -> ShadingView {
        let wo = -d.normalize();
        let ns = self.smooth.normalize_or(self.ng);
        let is_below = self.ng.dot(wo) < 0.0;
        let to_viewer = if is_below { -wo } else { wo };
        let outwards = outward(ns, self.ng);
        let short = MIN_VIEW_COS - outwards.dot(to_viewer);
        let facing = if short >= MIN_VIEW_COS {
            (outwards + to_viewer * short).normalize()
        } else {
            outwards
        };
        ShadingView {
            wo,
            ns,
            ray_origins: float::offset_origins(self.p, self.p_error, self.ng),
            frame: Frame::from_normal(facing),
        }
    }
}

/// Returns `n` flipped to the side of the geometric normal: where a mesh has reversed normals, the triangles decide.
#[inline(always)]
fn outward(n: Vec3, ng: Vec3) -> Vec3 {
    if n.dot(ng) < 0.0 { -n } else { n }
}

impl SurfaceInteraction {
    /// The shading normal on the side of the geometric one.
    #[inline]
    pub fn outward_normal(&self) -> Vec3 {
        outward(self.ns, self.ng)
    }

    /// An interaction with unspecified fields.
    pub(super) fn unset() -> Self {
        Self {
            t: 0.0,
            p: Vec3::ZERO,
            ray_origins: [Vec3::ZERO; 2],
            lift: Vec3::ZERO,
            ng: Vec3::ZERO,
            ns: Vec3::ZERO,
            frame: Frame {
                s: Vec3::ZERO,
                t: Vec3::ZERO,
                n: Vec3::ZERO,
            },
            dpdu: Vec3::ZERO,
            dpdv: Vec3::ZERO,
            tangent: Vec4::ZERO,
            height_axis: Vec3::ZERO,
            wo: Vec3::ZERO,
            texture: TexturePoint::new(Vec3::ZERO, Vec3::Y),
            object: ObjectId(0),
            material: MaterialId(0),
        }
    }

    /// Resets the fields that shading reads of every surface but not every hit sets: interactions are
    /// reused, and stale values would show.
    #[inline(always)]
    pub(super) fn clear_parameters(&mut self) {
        (self.dpdu, self.dpdv, self.tangent) = (Vec3::ZERO, Vec3::ZERO, Vec4::ZERO);
        self.texture.curvature = 0.0;
    }

    /// Sets the geometry and the shading view.
    #[inline(always)]
    pub(super) fn set_geometry(&mut self, geometry: &HitGeometry, view: &ShadingView) {
        (self.p, self.lift, self.ng) = (geometry.p, geometry.lift, geometry.ng);
        (self.wo, self.ns) = (view.wo, view.ns);
        (self.ray_origins, self.frame) = (view.ray_origins, view.frame);
    }

    /// Sets the footprint for texture filtering, from the width of the ray cone in m. The material's pictures
    /// have mostly `picture_size` texels.
    ///
    /// The cone intersects the surface in an ellipse, stretched by 1/cos along the projection of the ray.
    pub fn set_footprint(&mut self, width: f32, picture_size: Option<Vec2>) {
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
        // At a pole the parameters do not span the surface, and the footprint is undefined.
        self.texture.footprint = if area2 > 0.0 {
            [in_uv(across * width), in_uv(along * (width / cos))]
        } else {
            [Vec2::ZERO; 2]
        };
        let footprint = self.texture.footprint;
        self.texture.shared_footprint =
            picture_size.map_or(SharedFootprint::NONE, |size| SharedFootprint::new(footprint, size));
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

    /// The normal of [`SurfaceInteraction::frame`] on the side of the viewer.
    #[inline(always)]
    pub fn viewed_normal(&self) -> Vec3 {
        self.frame.n * self.viewed_side()
    }

    /// 1 where the viewer is in front, by the geometric normal, else -1.
    #[inline(always)]
    pub fn viewed_side(&self) -> f32 {
        if self.ng.dot(self.wo) >= 0.0 { 1.0 } else { -1.0 }
    }

    /// The ray that leaves along the unit direction `w`, on the viewer's side or, if `transmitted`, on the other.
    #[inline(always)]
    pub fn spawn_ray(&self, transmitted: bool, w: Vec3) -> Ray {
        Ray::new(self.origin(transmitted, w), w)
    }

    /// The ray segment to a light at `distance` from `p` along the unit direction `w`; it leaves on the viewer's side or, if
    /// `transmitted`, on the other.
    #[inline(always)]
    pub fn shadow_ray(&self, transmitted: bool, w: Vec3, distance: f32) -> Ray {
        let o = self.origin(transmitted, w);
        if distance.is_finite() {
            // The segment from the offset origin ends at the same point of the light.
            let d = self.p + w * distance - o;
            Ray::segment(o, d, 1.0)
        } else {
            Ray::new(o, w)
        }
    }

    #[inline(always)]
    fn origin(&self, transmitted: bool, w: Vec3) -> Vec3 {
        let [above, below] = self.ray_origins;
        // The side is unpredictable, so this avoids a branch.
        let is_below = (self.wo.dot(self.ng) < 0.0) != transmitted;
        let origin = float::select(is_below, below, above);
        if transmitted {
            return origin;
        }
        let side = self.viewed_side();
        origin + lift_along(w, self.lift, self.ng * side, self.frame.n * side)
    }
}

/// The part of `lift` by which a ray along `w` starts above a triangle with the normal `ng` and the shading normal `n`.
///
/// Rays that leave above the plane of the triangle start on it: no neighbour of a convex mesh is in their way, and what stands
/// on the triangle is. Others would start inside of the mesh. They rise with the angle below the plane, and from the plane on
/// which the shading normal is perpendicular they start on the curved surface.
#[inline(always)]
pub(super) fn lift_along(w: Vec3, lift: Vec3, ng: Vec3, n: Vec3) -> Vec3 {
    let below = -ng.dot(w);
    let part = below / (below + n.dot(w).max(0.0));
    lift * if below > 0.0 { part } else { 0.0 }
}

/// The unit normal nearest to `n` about which the mirror image of `wo` is above the surface.
///
/// All are unit and on the side of the viewer, who is in the direction `wo`; `n` is a shading normal and `ng` the normal of
/// the surface. Source: Keller et al., "The Iray Light Transport Simulation and Rendering System", 2017, section A.3.
pub fn reflecting_normal(n: Vec3, ng: Vec3, wo: Vec3) -> Vec3 {
    let mirrored = n * (2.0 * n.dot(wo)) - wo;
    let least = (0.9 * ng.dot(wo)).min(MIN_REFLECTED_COS);
    let above = mirrored.dot(ng);
    if above >= least {
        return n;
    }
    let raised = (mirrored + ng * (least - above)).normalize_or(ng);
    (wo + raised).normalize_or(ng)
}
