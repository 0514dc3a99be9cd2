//! The first hit of a camera ray: the record that the render loop fills and the passes of a film read.

use super::{ObjectId, SurfaceInteraction};
use crate::{
    geometry::{Hit, InstanceId, PrimId},
    material::MaterialId,
    math::{Rgb, Vec2, Vec3},
};

/// The first surface along a camera ray that does not let the ray pass, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstHit {
    pub p: Vec3,
    /// Unit geometric normal, as authored.
    pub ng: Vec3,
    /// Unit shading normal, as authored.
    pub ns: Vec3,
    /// Unit direction back to the camera.
    pub wo: Vec3,
    pub uv: Vec2,
    /// Distance from the ray's origin, in metres.
    pub distance: f32,
    /// The weights of the second and the third corner of its triangle.
    pub barycentric: [f32; 2],
    pub prim: PrimId,
    pub object: ObjectId,
    pub instance: InstanceId,
    pub material: MaterialId,
    /// An estimate of the albedo, see [`Scene::sample_albedo`](super::Scene::sample_albedo); black if no pass reads it.
    pub albedo: Rgb,
}

impl FirstHit {
    /// The record of `surface`, which a ray met with `hit` at `distance` metres.
    pub fn new(surface: &SurfaceInteraction, hit: &Hit, distance: f32) -> Self {
        Self {
            p: surface.p,
            ng: surface.ng,
            ns: surface.ns,
            wo: surface.wo,
            uv: surface.texture.true_uv(),
            distance,
            barycentric: [hit.u, hit.v],
            prim: hit.prim,
            object: surface.object,
            instance: hit.instance,
            material: surface.material,
            albedo: Rgb::BLACK,
        }
    }
}
