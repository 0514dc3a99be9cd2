//! The two halves of a scene, which change at different times.

use super::{
    Background, InstanceRecord, LightGroups, Media, MeshRecord, NodeName, Object, ObjectId,
    material_bsdfs::MaterialBsdfs,
};
use crate::{
    accel::Accelerator,
    material::Material,
    math::{Transform, Vec4},
    texture::{Bitmap, Texture},
};

/// The surfaces of a scene and what they are called. Motion changes it, see [`Scene::apply`](super::Scene::apply).
pub struct SceneGeometry {
    pub accel: Box<dyn Accelerator>,
    pub objects: Vec<Object>,
    /// In the order of their triangles, without gaps.
    pub meshes: Vec<MeshRecord>,
    /// The record of each instance of the geometry.
    pub instances: Vec<InstanceRecord>,
    /// The transforms that [`ObjectFromGroup::At`](super::ObjectFromGroup::At) refers to.
    pub object_transforms: Vec<Transform>,
    /// The object of each of the geometry's shapes.
    pub shape_objects: Vec<ObjectId>,
    /// Linear colours with opacity of the first shapes; the rest are white.
    pub shape_colors: Vec<Vec4>,
    /// The nodes of all model files.
    pub nodes: Vec<NodeName>,
}

/// The appearance of a scene: materials, their textures, and the background. New values and looks change it, see
/// [`Scene::with_shading`](super::Scene::with_shading).
pub struct SceneShading {
    pub materials: Vec<Material>,
    pub media: Media,
    /// One for each material; not unique, and possibly empty.
    pub material_names: Vec<String>,
    pub textures: Vec<Texture>,
    pub bitmaps: Vec<Bitmap>,
    pub light_groups: LightGroups,
    pub background: Background,
    /// Whether texture coordinates are computed for each material.
    pub(crate) is_spatially_varying: Vec<bool>,
    pub(crate) bsdfs: MaterialBsdfs,
}

impl SceneShading {
    /// Makes the shading of these materials, each with its name.
    pub fn new(
        (material_names, materials): (Vec<String>, Vec<Material>),
        (textures, bitmaps): (Vec<Texture>, Vec<Bitmap>),
        light_groups: LightGroups,
        background: Background,
    ) -> Self {
        let mut shading = Self {
            media: Media::new(&materials),
            is_spatially_varying: Vec::new(),
            bsdfs: MaterialBsdfs::new(&materials),
            materials,
            material_names,
            textures,
            bitmaps,
            light_groups,
            background,
        };
        // With filtered textures even the footprint in a mirror depends on the curvature at the point.
        let all = shading.reads_footprints();
        let varies = shading.materials.iter().map(|m| all || m.is_spatially_varying());
        shading.is_spatially_varying = varies.collect();
        shading
    }

    /// Whether a texture is filtered over the footprint of a ray, so that rays need cones.
    pub fn reads_footprints(&self) -> bool {
        self.bitmaps.iter().any(|b| !b.levels.is_empty())
    }
}
