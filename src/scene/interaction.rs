//! From a hit to the surface around it, and the rays that leave it.

use glam::Vec2Swizzles;

use super::{MeshRecord, ObjectId};
use crate::{
    accel::{Hit, Placed},
    material::MaterialId,
    math::{Frame, Ray, Transform, Vec2, Vec3, float},
    shape::{ShapeHit, triangle},
    texture::TexturePoint,
};

/// A grazing ray counts as one of this cosine: beyond it the ellipse that it covers grows without bound.
const LEAST_COS: f32 = 1.0 / 64.0;

/// A place that nobody asks for.
fn anywhere(uv: Vec2) -> TexturePoint {
    TexturePoint {
        uv,
        ..TexturePoint::new(Vec3::ZERO, Vec3::Y)
    }
}

/// A surface where a ray met it, in world space. Normals are as authored.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// In lengths of the ray's direction.
    pub t: f32,
    pub p: Vec3,
    /// Bound on the absolute error of each coordinate of `p`.
    pub p_error: Vec3,
    /// Unit geometric normal.
    pub ng: Vec3,
    /// Unit shading normal.
    pub ns: Vec3,
    /// How `p` moves with the texture coordinates; zero where there are none.
    pub dpdu: Vec3,
    pub dpdv: Vec3,
    /// Unit direction back along the ray.
    pub wo: Vec3,
    /// The place in the object's own space; of one whose material is the same everywhere `uv` alone.
    pub texture: TexturePoint,
    pub object: ObjectId,
    pub material: MaterialId,
}

impl Surface {
    /// `varies` says whether the place on textures is asked for.
    #[inline(always)]
    pub(super) fn of_shape(
        placed: &Placed,
        transform: Option<&Transform>,
        ray: &Ray,
        hit: &Hit,
        object: ObjectId,
        material: MaterialId,
        varies: bool,
    ) -> Self {
        let shape_hit = ShapeHit {
            t: hit.t,
            u: hit.u,
            v: hit.v,
        };
        let local_ray = transform.map_or(*ray, |t| t.ray_to_local(ray));
        let local = placed.shape.surface(&local_ray, &shape_hit);
        let (p, p_error, ng, [dpdu, dpdv]) = match transform {
            None => (local.p, local.p_error, local.ng, [local.dpdu, local.dpdv]),
            Some(t) => (
                t.point_to_world(local.p),
                t.point_error_to_world(local.p, local.p_error),
                t.normal_to_world(local.ng).normalize(),
                [local.dpdu, local.dpdv].map(|d| t.vector_to_world(d)),
            ),
        };
        Self {
            t: hit.t,
            p,
            p_error,
            ng,
            ns: ng,
            dpdu,
            dpdv,
            wo: -ray.d.normalize(),
            texture: if varies {
                TexturePoint {
                    uv: local.uv,
                    dpdu: local.dpdu,
                    dpdv: local.dpdv,
                    curvature: placed.shape.curvature(),
                    ..TexturePoint::new(local.p, local.ng)
                }
            } else {
                anywhere(local.uv)
            },
            object,
            material,
        }
    }

    /// Of an instanced triangle `place` says where it stands; the place on the texture, which `varies` asks for, is in the mesh's
    /// space then.
    #[inline(always)]
    pub(super) fn of_triangle(
        corners: [Vec3; 3],
        vertices: [u32; 3],
        mesh: &MeshRecord,
        place: Option<&Transform>,
        ray: &Ray,
        hit: &Hit,
        varies: bool,
    ) -> Self {
        let at = vertices.map(|v| (v - mesh.vertices.start) as usize);
        let uvs = (!mesh.uvs.is_empty()).then(|| at.map(|i| mesh.uvs[i]));
        let mut local = triangle::surface(corners, uvs, hit.u, hit.v);
        if uvs.is_none() && place.is_some_and(Transform::is_mirroring) {
            // A copy in world space would have its last two corners in the other order.
            local.uv = local.uv.yx();
            (local.dpdu, local.dpdv) = (local.dpdv, local.dpdu);
        }
        let (p, p_error, ng, [dpdu, dpdv]) = match place {
            None => (local.p, local.p_error, local.ng, [local.dpdu, local.dpdv]),
            Some(t) => {
                let p = t.point_to_world(local.p);
                let p_error = t.point_error_to_world(local.p, local.p_error) + t.return_error(p);
                let ng = t.normal_to_world(local.ng).normalize();
                (p, p_error, ng, [local.dpdu, local.dpdv].map(|d| t.vector_to_world(d)))
            }
        };
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let ns = if mesh.normals.is_empty() {
            ng
        } else {
            let normal = |k: usize| match place {
                None => mesh.normals[at[k]],
                Some(t) => t.normal_to_world(mesh.normals[at[k]]).normalize_or_zero(),
            };
            let sum: Vec3 = (0..3).map(|k| normal(k) * weights[k]).sum();
            sum.try_normalize().unwrap_or(ng)
        };
        Self {
            t: hit.t,
            p,
            p_error,
            ng,
            ns,
            dpdu,
            dpdv,
            wo: -ray.d.normalize(),
            texture: match &mesh.transform {
                _ if !varies => anywhere(local.uv),
                None => TexturePoint {
                    uv: local.uv,
                    dpdu: local.dpdu,
                    dpdv: local.dpdv,
                    ..TexturePoint::new(local.p, local.ng)
                },
                Some(t) => TexturePoint {
                    uv: local.uv,
                    dpdu: t.vector_to_local(local.dpdu),
                    dpdv: t.vector_to_local(local.dpdv),
                    ..TexturePoint::new(t.point_to_local(local.p), t.normal_to_local(local.ng).normalize())
                },
            },
            object: mesh.object,
            material: mesh.material,
        }
    }

    /// Says how wide the bundle of rays is that arrives here, in m: what of the surface textures look at.
    ///
    /// A round bundle meets the surface in an ellipse, longer by 1/cos in the direction in which the ray slants.
    pub fn cover(&mut self, width: f32) {
        let (u, v) = (self.dpdu, self.dpdv);
        let area = u.cross(v);
        let area2 = area.length_squared();
        let cos = self.ng.dot(self.wo).abs().max(LEAST_COS);
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

    /// How fast the surface bends away from the viewer, in m^-1; negative where it is hollow.
    pub fn bend(&self) -> f32 {
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
        Ray::new(float::offset_origin(self.p, self.p_error, self.ng, w), w)
    }

    /// The ray towards a light `distance` away along the unit direction `w`, up to the light.
    #[inline(always)]
    pub fn shadow_ray(&self, w: Vec3, distance: f32) -> Ray {
        let o = float::offset_origin(self.p, self.p_error, self.ng, w);
        if distance.is_finite() {
            // From the moved origin to the same point: neither short of the light nor past it.
            let d = self.p + w * distance - o;
            Ray::segment(o, d, 1.0)
        } else {
            Ray::new(o, w)
        }
    }
}
