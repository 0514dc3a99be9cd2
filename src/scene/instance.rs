//! The object and the material of an instance.

use super::{NodeId, ObjectId, SurfaceInteraction, interaction::HitGeometry};
use crate::{
    material::MaterialId,
    math::{Transform, Vec3},
    texture::TextureSpace,
};

/// The transform from the space of an instance's group to the space of its object, in which
/// textures are evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjectFromGroup {
    /// The two spaces are the same.
    Identity,
    /// The object's space is world space until the object is moved.
    WorldFromGroup,
    /// An index into [`SceneGeometry::object_transforms`](super::SceneGeometry::object_transforms).
    At(u32),
}

/// The scene data of an instance of the geometry.
#[derive(Clone, Copy, Debug)]
pub struct InstanceRecord {
    pub object: ObjectId,
    /// Replaces the materials of the meshes.
    pub material: Option<MaterialId>,
    pub object_from_group: ObjectFromGroup,
    /// The model node of the instance, instead of those of the meshes.
    pub node: Option<NodeId>,
    /// The number of its first copy of a mesh.
    pub first_copy: u32,
}

impl InstanceRecord {
    /// Sets the texture point of `surface`, transformed from the group's space into the object's.
    pub(super) fn fill_texture_point(
        &self,
        surface: &mut SurfaceInteraction,
        geometry: &HitGeometry,
        object_transforms: &[Transform],
    ) {
        let texture = &mut surface.texture;
        match self.object_from_group {
            ObjectFromGroup::Identity => {}
            ObjectFromGroup::WorldFromGroup => {
                (texture.p, texture.n) = (geometry.p, geometry.ng);
                texture.space = TextureSpace::Scene;
                (texture.dpdu, texture.dpdv) = (surface.dpdu, surface.dpdv);
            }
            ObjectFromGroup::At(place) => {
                let place = &object_transforms[place as usize];
                texture.p = place.point_to_world(texture.p);
                texture.n = place.normal_to_world(texture.n).normalize();
                texture.dpdu = place.vector_to_world(texture.dpdu);
                texture.dpdv = place.vector_to_world(texture.dpdv);
            }
        }
    }

    /// The image in the scene of `n` in the object's own space.
    pub(super) fn height_axis(&self, n: Vec3, world_from_group: &Transform, object_transforms: &[Transform]) -> Vec3 {
        match self.object_from_group {
            ObjectFromGroup::Identity => world_from_group.vector_to_world(n),
            ObjectFromGroup::WorldFromGroup => n,
            ObjectFromGroup::At(place) => {
                world_from_group.vector_to_world(object_transforms[place as usize].vector_to_local(n))
            }
        }
    }
}
