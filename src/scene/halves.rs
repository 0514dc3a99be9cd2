//! The two halves of a scene, which change at different times.

use std::sync::Arc;

use super::{
    Background, InstanceRecord, LightGroups, LightId, LightLinks, MaterialBackFaces, Media, MeshRecord, NodeId,
    NodeName, Object, ObjectId, contacts::Contacts, material_bsdfs::MaterialBsdfs,
};
use crate::{
    accel::Accelerator,
    geometry::PrimId,
    light::{Light, LightTables, Profile},
    material::{Material, MaterialId, NormalMap},
    math::{Runs, Transform, Vec2, Vec4},
    texture::{Bitmap, StTransform, Texture, TextureId, TexturePoint, Textures},
};

/// The surfaces of a scene and what they are called. Motion changes it, see [`Scene::apply`](super::Scene::apply).
pub struct SceneGeometry {
    pub accel: Box<dyn Accelerator>,
    pub objects: Vec<Object>,
    /// In the order of their triangles, without gaps.
    pub meshes: Vec<MeshRecord>,
    /// The triangles of each mesh.
    pub(super) mesh_runs: Runs,
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
    /// The nodes of objects that have their names and numbers whether they are seen or not.
    pub named_nodes: Vec<(ObjectId, NodeId)>,
    /// The objects that are not visible and their nodes, in the order that they would have otherwise.
    /// They keep their mattes and numbers.
    pub hidden: Vec<(ObjectId, Option<NodeId>)>,
    pub contacts: Contacts,
}

impl SceneGeometry {
    /// The material of one of the geometry's shapes.
    pub fn shape_material(&self, shape: u32) -> MaterialId {
        self.objects[self.shape_objects[shape as usize].0 as usize].material
    }

    /// The index of the mesh of triangle `prim`; of a shape, the number of meshes.
    #[inline]
    pub(super) fn mesh_index(&self, prim: PrimId) -> usize {
        self.mesh_runs.of(prim.index())
    }

    /// The mesh of triangle `prim`; `None` for a shape.
    #[inline]
    pub(super) fn mesh_of(&self, prim: PrimId) -> Option<&MeshRecord> {
        self.meshes.get(self.mesh_index(prim))
    }
}

/// The appearance of a scene: materials, their textures, analytic lights, and the background. New values and looks change it, see
/// [`Scene::with_shading`](super::Scene::with_shading).
pub struct SceneShading {
    pub materials: Vec<Material>,
    pub media: Media,
    /// One for each material; not unique, and possibly empty.
    pub material_names: Vec<String>,
    pub textures: Vec<Texture>,
    pub bitmaps: Vec<Bitmap>,
    /// The analytic lights, in the order of the scene file.
    pub lights: Arc<[Light]>,
    /// The profiles that lights refer to.
    pub profiles: Vec<Profile>,
    pub light_groups: LightGroups,
    pub light_links: LightLinks,
    pub background: Background,
    /// The back faces of the first materials; those of the rest are shaded.
    pub(super) back_faces: Vec<MaterialBackFaces>,
    /// The material of black backs: one more than have names. `None` where no back is black.
    pub(super) black: Option<MaterialId>,
    /// See [`MaterialKind::is_spatially_varying`](crate::material::MaterialKind), for each material.
    is_spatially_varying: Vec<bool>,
    /// See [`SceneShading::picture_size`], for each material.
    picture_sizes: Vec<Option<Vec2>>,
    has_mixtures: bool,
    reads_footprints: bool,
    reads_scene_places: bool,
    pub(crate) bsdfs: MaterialBsdfs,
    /// Whether a material has a map of heights.
    reads_heights: bool,
    /// The normal map of each material.
    normal_maps: Vec<Option<MaterialNormalMap>>,
}

/// The normal map of a material.
#[derive(Clone, Copy, Debug)]
struct MaterialNormalMap {
    map: NormalMap,
    /// Whether it is given to the material, rather than the material's own.
    is_given: bool,
}

impl MaterialNormalMap {
    fn given(map: NormalMap) -> Self {
        Self { map, is_given: true }
    }

    fn own(map: NormalMap) -> Self {
        Self { map, is_given: false }
    }
}

/// New values of the shading.
#[derive(Default)]
pub struct ShadingUpdate {
    pub materials: Vec<(MaterialId, Material)>,
    /// The normal maps that are given to materials.
    pub normal_maps: Vec<(MaterialId, Option<NormalMap>)>,
    /// The transforms of textures.
    pub textures: Vec<(TextureId, StTransform)>,
    /// Analytic lights.
    pub lights: Vec<(LightId, Light)>,
    pub background: Option<Background>,
}

impl ShadingUpdate {
    /// Whether nothing changes.
    pub fn is_empty(&self) -> bool {
        self.materials.is_empty()
            && self.normal_maps.is_empty()
            && self.textures.is_empty()
            && self.lights.is_empty()
            && self.background.is_none()
    }
}

impl SceneShading {
    /// Creates the shading from materials with their names and given normal maps, textures with their bitmaps, analytic lights with
    /// their profiles, light groups and light links, and the background.
    pub fn new(
        (material_names, materials, given_normal_maps): (Vec<String>, Vec<Material>, Vec<Option<NormalMap>>),
        (textures, bitmaps): (Vec<Texture>, Vec<Bitmap>),
        (lights, profiles): (Vec<Light>, Vec<Profile>),
        (light_groups, light_links): (LightGroups, LightLinks),
        background: Background,
    ) -> Self {
        let mut shading = Self {
            media: Media::default(),
            is_spatially_varying: Vec::new(),
            picture_sizes: Vec::new(),
            has_mixtures: false,
            reads_footprints: bitmaps.iter().any(|b| !b.levels.is_empty())
                || textures.iter().any(|texture| texture.pattern.is_band_limited()),
            reads_scene_places: textures.iter().any(Texture::reads_scene),
            bsdfs: MaterialBsdfs::default(),
            reads_heights: false,
            normal_maps: given_normal_maps
                .into_iter()
                .map(|map| map.map(MaterialNormalMap::given))
                .collect(),
            materials,
            material_names,
            textures,
            bitmaps,
            lights: lights.into(),
            profiles,
            light_groups,
            light_links,
            background,
            back_faces: Vec::new(),
            black: None,
        };
        shading.derive();
        shading
    }

    /// Replaces these values.
    pub(super) fn update(&mut self, update: ShadingUpdate) {
        let has_materials = !(update.materials.is_empty() && update.normal_maps.is_empty());
        for (id, material) in update.materials {
            self.materials[id.0 as usize] = material;
        }
        for (id, map) in update.normal_maps {
            self.normal_maps[id.0 as usize] = map.map(MaterialNormalMap::given);
        }
        for (id, transform) in update.textures {
            let texture = &mut self.textures[id.0 as usize];
            *texture = Texture { transform, ..*texture }.prepared();
        }
        if !update.lights.is_empty() {
            let mut lights = self.lights.to_vec();
            for (id, light) in update.lights {
                lights[id.0 as usize] = light;
            }
            self.lights = lights.into();
        }
        if let Some(background) = update.background {
            self.background = background;
        }
        if has_materials {
            self.derive();
        }
    }

    /// Computes what follows from the materials.
    fn derive(&mut self) {
        self.media = Media::new(&self.materials);
        self.normal_maps.resize(self.materials.len(), None);
        for (map, material) in self.normal_maps.iter_mut().zip(&self.materials) {
            let given = map.filter(|map| map.is_given);
            *map = given.or_else(|| material.normal_map().map(MaterialNormalMap::own));
        }
        let is_given = |id: MaterialId| self.given_normal_map(id).is_some();
        self.bsdfs = MaterialBsdfs::new(&self.materials, is_given);
        let maps = self.normal_maps.iter();
        let varies = |(material, map): (&Material, &Option<_>)| material.is_spatially_varying() || map.is_some();
        self.is_spatially_varying = self.materials.iter().zip(maps.clone()).map(varies).collect();
        self.picture_sizes = self
            .materials
            .iter()
            .map(|material| self.size_of_pictures(material))
            .collect();
        self.reads_heights = maps.flatten().any(|own| matches!(own.map, NormalMap::Heights(_)));
        self.has_mixtures = self.materials.iter().any(|material| material.mixture().is_some());
    }

    #[inline]
    pub fn material(&self, id: MaterialId) -> &Material {
        &self.materials[id.0 as usize]
    }

    /// The normal map of a material: the one that it is given, or its own.
    #[inline]
    pub fn normal_map(&self, id: MaterialId) -> Option<&NormalMap> {
        self.normal_maps[id.0 as usize].as_ref().map(|own| &own.map)
    }

    /// The normal map that a material is given in place of its own.
    pub(super) fn given_normal_map(&self, id: MaterialId) -> Option<&NormalMap> {
        let own = self.normal_maps[id.0 as usize].as_ref();
        own.filter(|own| own.is_given).map(|own| &own.map)
    }

    /// The textures and bitmaps that materials refer to.
    #[inline]
    pub fn textures(&self) -> Textures<'_> {
        Textures {
            textures: &self.textures,
            bitmaps: &self.bitmaps,
        }
    }

    /// The tables that analytic lights refer to, without pictures.
    #[inline(always)]
    pub fn light_tables(&self) -> LightTables<'_> {
        LightTables {
            profiles: &self.profiles,
            textures: self.textures(),
            picture: None,
        }
    }

    /// Whether `material` needs texture points.
    #[inline]
    pub(crate) fn is_spatially_varying(&self, material: MaterialId) -> bool {
        self.is_spatially_varying
            .get(material.0 as usize)
            .is_none_or(|varies| *varies)
    }

    /// The size in texels that the pictures of a material mostly have, if several are read at a point.
    #[inline]
    pub(crate) fn picture_size(&self, material: MaterialId) -> Option<Vec2> {
        self.picture_sizes.get(material.0 as usize).copied().flatten()
    }

    fn size_of_pictures(&self, material: &Material) -> Option<Vec2> {
        let texture = &self.textures[material.one_of_textures()?.0 as usize];
        let bitmap = texture.pattern.filtered_bitmap()?;
        let bitmap = &self.bitmaps[bitmap.0 as usize];
        Some(Vec2::new(bitmap.width as f32, bitmap.height as f32))
    }

    /// Whether any material is a mixture.
    #[inline]
    pub(crate) fn has_mixtures(&self) -> bool {
        self.has_mixtures
    }

    /// The material that is shaded at a point for `material`: where that is a mixture, one of its materials,
    /// chosen by a random number in `[0, 1)`.
    pub(crate) fn unmixed(&self, mut material: MaterialId, at: &TexturePoint, mut number: f32) -> MaterialId {
        while let Some(mixture) = self.material(material).mixture() {
            (material, number) = mixture.choose(&self.textures(), at, number);
        }
        material
    }

    /// Whether a material has a map of heights, which reads [`SurfaceInteraction::height_axis`](super::SurfaceInteraction).
    #[inline]
    pub(super) fn reads_heights(&self) -> bool {
        self.reads_heights
    }

    /// Whether a texture reads where its points are in the scene.
    #[inline]
    pub(super) fn reads_scene_places(&self) -> bool {
        self.reads_scene_places
    }

    /// Whether a texture is filtered over the footprint of a ray, so that rays need cones.
    #[inline]
    pub fn reads_footprints(&self) -> bool {
        self.reads_footprints
    }
}
