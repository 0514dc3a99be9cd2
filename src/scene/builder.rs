//! Assembly of a [`Scene`], piece by piece: by `compile` from a description, by programs in code.

mod colors;
mod lights;
mod settings;

use std::sync::Arc;

use super::{
    Background, InstanceRecord, LightGroups, LightLinks, LightSetId, MaterialBackFaces, MeshRecord, NodeId, NodeName,
    Object, ObjectFromGroup, ObjectId, ObjectRole, RayVisibility, Scene, SceneBuildError, SceneGeometry, SceneShading,
    back_faces::UsedBackFaces, contacts::Contacts, mesh_transform::MeshTransform,
};
use crate::{
    accel::{self, BuildOptions},
    geometry::{BuildError, Geometry, GroupInstance, MeshGroup, PlacedShape, check},
    light::{Light, Profile},
    material::{Material, MaterialId, NormalMap},
    math::{DVec3, Runs, Transform, Vec4},
    shape::{
        Shape,
        mesh::{Mesh, MeshError},
    },
    texture::{Bitmap, BitmapId, Texture, TextureId, Textures, mipmap},
};

/// Meshes that are stored once for any number of instances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GroupId(pub u32);

/// The owner of a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshOwner {
    pub object: ObjectId,
    pub material: MaterialId,
    /// The object's transform: textures are evaluated in the object's own space.
    pub transform: Option<Transform>,
    pub node: Option<NodeId>,
    /// See [`MeshRecord::copy`].
    pub copy: Option<u32>,
}

/// A scene without its acceleration structure and its tables of lights. Ids that a method returns stay valid in the
/// scene that [`SceneBuilder::build`] makes.
#[derive(Clone, Debug)]
pub struct SceneBuilder {
    origin: DVec3,
    geometry: Geometry,
    objects: Vec<Object>,
    meshes: Vec<MeshRecord>,
    instances: Vec<InstanceRecord>,
    object_transforms: Vec<Transform>,
    shape_objects: Vec<ObjectId>,
    shape_colors: Vec<Vec4>,
    nodes: Vec<NodeName>,
    named_nodes: Vec<(ObjectId, NodeId)>,
    /// The parts of objects that are not visible, see [`SceneGeometry::hidden`].
    hidden: Vec<(ObjectId, Option<NodeId>)>,
    /// The number of copies of meshes so far.
    copies: u32,
    materials: Vec<Material>,
    material_names: Vec<String>,
    /// The back faces of the first materials; those of the rest are shaded.
    back_faces: Vec<MaterialBackFaces>,
    /// The normal maps that are given to the first materials.
    normal_maps: Vec<Option<NormalMap>>,
    textures: Vec<Texture>,
    bitmaps: Vec<Bitmap>,
    lights: Vec<Light>,
    profiles: Vec<Profile>,
    light_groups: LightGroups,
    light_links: LightLinks,
    background: Background,
}

impl SceneBuilder {
    pub fn new(background: Background) -> Self {
        Self {
            origin: DVec3::ZERO,
            geometry: Geometry::default(),
            objects: Vec::new(),
            meshes: Vec::new(),
            instances: Vec::new(),
            object_transforms: Vec::new(),
            shape_objects: Vec::new(),
            shape_colors: Vec::new(),
            nodes: Vec::new(),
            named_nodes: Vec::new(),
            hidden: Vec::new(),
            copies: 0,
            materials: Vec::new(),
            material_names: Vec::new(),
            back_faces: Vec::new(),
            normal_maps: Vec::new(),
            textures: Vec::new(),
            bitmaps: Vec::new(),
            lights: Vec::new(),
            profiles: Vec::new(),
            light_groups: LightGroups::default(),
            light_links: LightLinks::default(),
            background,
        }
    }

    /// Sets the scene's origin in world space, in m, to which all positions are relative; 0 by default. Single precision must
    /// represent it exactly.
    pub fn set_origin(&mut self, origin: DVec3) {
        self.origin = origin;
    }

    /// The place in the world of the point that positions are relative to.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Replaces the background.
    pub fn set_background(&mut self, background: Background) {
        self.background = background;
    }

    pub fn bitmap(&mut self, bitmap: Bitmap) -> BitmapId {
        self.bitmaps.push(bitmap);
        BitmapId(self.bitmaps.len() as u32 - 1)
    }

    pub fn texture(&mut self, texture: Texture) -> TextureId {
        self.textures.push(texture.prepared());
        TextureId(self.textures.len() as u32 - 1)
    }

    /// Adds a material with the name `material N`, counted from 1.
    pub fn material(&mut self, material: Material) -> MaterialId {
        let name = format!("material {}", self.materials.len() + 1);
        self.named_material(&name, material)
    }

    pub fn named_material(&mut self, name: &str, material: Material) -> MaterialId {
        self.materials.push(material);
        self.material_names.push(name.to_owned());
        MaterialId(self.materials.len() as u32 - 1)
    }

    /// Gives a material a normal map in place of its own.
    pub fn set_normal_map(&mut self, material: MaterialId, map: NormalMap) {
        let at = material.0 as usize;
        let count = self.normal_maps.len().max(at + 1);
        self.normal_maps.resize(count, None);
        self.normal_maps[at] = Some(map);
    }

    /// Adds an object that is a shape.
    pub fn shape(&mut self, name: &str, shape: Shape, transform: Option<Transform>, material: MaterialId) -> ObjectId {
        let object = self.object(name, None, material);
        self.object_shape(object, shape, transform, Vec4::ONE);
        object
    }

    /// Adds a shape to an object. `color` (linear, with opacity) multiplies that of materials that use vertex colours.
    pub(crate) fn object_shape(&mut self, object: ObjectId, shape: Shape, transform: Option<Transform>, color: Vec4) {
        self.geometry.add_shape(shape, transform);
        if color != Vec4::ONE {
            // Shapes before the first coloured one are white.
            self.shape_colors.resize(self.shape_objects.len(), Vec4::ONE);
            self.shape_colors.push(color);
        }
        self.shape_objects.push(object);
    }

    /// The bytes that each shape takes.
    pub(crate) const SHAPE_BYTES: u64 = (size_of::<PlacedShape>() + size_of::<ObjectId>() + size_of::<Vec4>()) as u64;

    /// The bytes that each instance takes.
    pub(crate) const INSTANCE_BYTES: u64 =
        (size_of::<GroupInstance>() + size_of::<Transform>() + size_of::<InstanceRecord>()) as u64;

    /// The bytes that each mesh takes beside its arrays.
    pub(crate) const MESH_BYTES: u64 = size_of::<MeshRecord>() as u64;

    /// Makes room for as many more shapes.
    pub(crate) fn reserve_shapes(&mut self, count: usize) {
        self.geometry.shapes.reserve_exact(count);
        self.shape_objects.reserve_exact(count);
    }

    /// Adds an object that is a mesh; its vertices and normals are in world space.
    pub fn mesh(&mut self, name: &str, mesh: Mesh, material: MaterialId) -> Result<ObjectId, MeshError> {
        mesh.validate()?;
        let object = self.object(name, None, material);
        self.add_mesh(mesh, object, material, None);
        Ok(object)
    }

    /// Adds meshes in a space of their own, each with its material, for [`SceneBuilder::instance`].
    pub fn group(&mut self, meshes: Vec<(Mesh, MaterialId)>) -> Result<GroupId, MeshError> {
        meshes.iter().try_for_each(|(mesh, _)| mesh.validate())?;
        let first_triangle = self.geometry.triangles.len() as u32;
        let first_vertex = self.geometry.vertices.len() as u32;
        for (mesh, material) in meshes {
            self.add_mesh(mesh, ObjectId(0), material, Some(0));
        }
        Ok(self.end_group(first_triangle, first_vertex))
    }

    /// Adds an object that is an instance of a group; it can be moved. `material` overrides the materials of the group.
    pub fn instance(
        &mut self,
        name: &str,
        group: GroupId,
        transform: Transform,
        material: Option<MaterialId>,
    ) -> ObjectId {
        let object = self.object(name, None, material.unwrap_or(MaterialId(0)));
        let record = InstanceRecord {
            object,
            material,
            object_from_group: ObjectFromGroup::Identity,
            node: None,
            first_copy: self.add_copies(1),
        };
        self.place_group(group, transform, record);
        object
    }

    /// Adds an object without geometry. `asset` is the file that its geometry comes from.
    pub(crate) fn object(&mut self, name: &str, asset: Option<&str>, material: MaterialId) -> ObjectId {
        self.objects.push(Object {
            name: name.to_owned(),
            asset: asset.map(str::to_owned),
            material,
            rays: RayVisibility::default(),
            role: ObjectRole::default(),
            lit_by: LightSetId::default(),
            back_faces: None,
            part_of: None,
        });
        ObjectId(self.objects.len() as u32 - 1)
    }

    /// Adds the nodes of a model; parents are indices into `nodes`. Returns the id of the first.
    pub(crate) fn model_nodes<'a>(&mut self, nodes: impl Iterator<Item = (&'a str, Option<usize>)>) -> NodeId {
        let first = self.nodes.len() as u32;
        self.nodes.extend(nodes.map(|(name, parent)| NodeName {
            name: name.to_owned(),
            parent: parent.map(|p| NodeId(first + p as u32)),
        }));
        NodeId(first)
    }

    /// Gives a node of an object its name and its number, also where it has nothing to see.
    pub(crate) fn name_node(&mut self, object: ObjectId, node: NodeId) {
        self.named_nodes.push((object, node));
    }

    /// Counts this many copies of meshes more; returns the number of the first, from 0.
    pub(crate) fn add_copies(&mut self, count: u32) -> u32 {
        let first = self.copies;
        self.copies += count;
        first
    }

    /// Adds a transform for [`ObjectFromGroup::At`].
    pub(crate) fn object_place(&mut self, transform: Transform) -> ObjectFromGroup {
        self.object_transforms.push(transform);
        ObjectFromGroup::At(self.object_transforms.len() as u32 - 1)
    }

    /// Adds a transformed mesh to an object; returns the number of triangles that were left out because they have no area.
    pub(crate) fn transformed_mesh(&mut self, owner: &MeshOwner, mesh: &Mesh, transform: &MeshTransform) -> usize {
        let first_vertex = self.geometry.vertices.len() as u32;
        let first_triangle = self.geometry.triangles.len() as u32;
        transform.append(mesh, &mut self.geometry.vertices, &mut self.geometry.triangles);
        let end = self.geometry.triangles.len() as u32;
        if end > first_triangle {
            self.meshes.push(MeshRecord {
                object: owner.object,
                material: owner.material,
                transform: owner.transform,
                node: owner.node,
                copy: owner.copy,
                triangles: first_triangle..end,
                vertices: first_vertex..self.geometry.vertices.len() as u32,
                normals: mesh.normals.iter().map(|n| transform.normal(*n)).collect(),
                uvs: mesh.uvs.clone(),
                second_uvs: mesh.second_uvs.clone(),
                uv_origins: mesh.uv_origins,
                colors: mesh.colors.clone(),
                tangents: mesh.tangents.iter().map(|t| transform.tangent(*t)).collect(),
            });
        }
        mesh.triangles.len() - (end - first_triangle) as usize
    }

    /// The number of meshes so far.
    pub(crate) fn mesh_count(&self) -> u32 {
        self.meshes.len() as u32
    }

    /// The number of instances so far.
    pub(crate) fn instance_count(&self) -> u32 {
        self.instances.len() as u32
    }

    /// Makes a group of all triangles and vertices from these indices on.
    pub(crate) fn end_group(&mut self, first_triangle: u32, first_vertex: u32) -> GroupId {
        self.geometry.groups.push(MeshGroup {
            triangles: first_triangle..self.geometry.triangles.len() as u32,
            vertices: first_vertex..self.geometry.vertices.len() as u32,
        });
        GroupId(self.geometry.groups.len() as u32 - 1)
    }

    /// Adds an instance of a group to the object that `record` names.
    pub(crate) fn place_group(&mut self, group: GroupId, transform: Transform, record: InstanceRecord) {
        self.geometry.instances.push(GroupInstance {
            group: group.0,
            transform: self.geometry.transforms.len() as u32,
        });
        self.geometry.transforms.push(transform);
        self.instances.push(record);
    }

    fn add_mesh(&mut self, mesh: Mesh, object: ObjectId, material: MaterialId, copy: Option<u32>) {
        let first_vertex = self.geometry.vertices.len() as u32;
        let first_triangle = self.geometry.triangles.len() as u32;
        self.geometry.vertices.extend(mesh.positions);
        let moved = mesh.triangles.iter().map(|t| t.map(|v| v + first_vertex));
        self.geometry.triangles.extend(moved);
        self.meshes.push(MeshRecord {
            object,
            material,
            transform: None,
            node: None,
            copy,
            triangles: first_triangle..self.geometry.triangles.len() as u32,
            vertices: first_vertex..self.geometry.vertices.len() as u32,
            normals: mesh.normals,
            uvs: mesh.uvs,
            second_uvs: mesh.second_uvs,
            uv_origins: mesh.uv_origins,
            colors: mesh.colors,
            tangents: mesh.tangents,
        });
    }

    /// The geometry that rays will be traced against.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    pub fn background(&self) -> &Background {
        &self.background
    }

    pub fn material_of(&self, id: MaterialId) -> &Material {
        &self.materials[id.0 as usize]
    }

    /// Each material with its name.
    pub fn materials(&self) -> impl ExactSizeIterator<Item = (&str, &Material)> {
        let names = self.material_names.iter().map(String::as_str);
        names.zip(&self.materials)
    }

    /// The textures and bitmaps that materials refer to.
    pub fn textures(&self) -> Textures<'_> {
        Textures {
            textures: &self.textures,
            bitmaps: &self.bitmaps,
        }
    }

    /// Adds the name of the object at fault to an error.
    fn build_error(&self, cause: BuildError) -> SceneBuildError {
        let owner = |prim: usize| match prim.checked_sub(self.geometry.triangles.len()) {
            Some(shape) => self.shape_objects.get(shape).copied(),
            None => {
                let mesh = self.meshes.iter().find(|m| m.triangles.contains(&(prim as u32)));
                mesh.map(|m| m.object)
            }
        };
        let placed = |instance: usize| self.instances.get(instance).map(|i| i.object);
        let object = cause.prim().and_then(owner).or(cause.instance().and_then(placed));
        let object = object.map(|id| &self.objects[id.0 as usize]);
        SceneBuildError {
            object: object.map(|o| o.name.clone()),
            asset: object.and_then(|o| o.asset.clone()),
            cause,
        }
    }

    /// Validates the geometry as [`SceneBuilder::build`] does.
    ///
    /// # Errors
    /// The geometry is wrong; the error names the object.
    pub fn check(&self) -> Result<(), SceneBuildError> {
        check::whole(&self.geometry).map_err(|cause| self.build_error(cause))
    }

    /// The objects so far.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// The images so far.
    pub fn bitmaps(&self) -> &[Bitmap] {
        &self.bitmaps
    }

    /// The number of textures so far.
    pub fn texture_count(&self) -> usize {
        self.textures.len()
    }

    /// Builds the acceleration structure and the tables of lights, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// The geometry is wrong; the error names the object.
    pub fn build(mut self, accel: impl Into<BuildOptions>) -> Result<Scene, SceneBuildError> {
        mipmap::add_levels(&self.textures, &mut self.bitmaps);
        let geometry = Arc::new(std::mem::take(&mut self.geometry));
        let accel = match accel::build(accel, Arc::clone(&geometry)) {
            Ok(accel) => accel,
            Err(cause) => {
                self.geometry = Arc::unwrap_or_clone(geometry);
                return Err(self.build_error(cause));
            }
        };
        let geometry = SceneGeometry {
            contacts: Contacts::new(accel.geometry()),
            accel,
            objects: self.objects,
            mesh_runs: Runs::new(
                self.meshes.iter().map(|mesh| mesh.triangles.start).collect(),
                self.meshes.last().map_or(0, |mesh| mesh.triangles.end),
            ),
            meshes: self.meshes,
            instances: self.instances,
            object_transforms: self.object_transforms,
            shape_objects: self.shape_objects,
            shape_colors: self.shape_colors,
            nodes: self.nodes,
            named_nodes: self.named_nodes,
            hidden: self.hidden,
        };
        let of_objects = geometry.objects.iter().map(|object| object.back_faces);
        let mut materials = self.materials;
        let black = UsedBackFaces::new(of_objects, &self.back_faces).black.then(|| {
            materials.push(Material::black());
            MaterialId(materials.len() as u32 - 1)
        });
        let mut shading = SceneShading::new(
            (self.material_names, materials, self.normal_maps),
            (self.textures, self.bitmaps),
            (self.lights, self.profiles),
            (self.light_groups, self.light_links),
            self.background,
        );
        shading.back_faces = self.back_faces;
        shading.black = black;
        Ok(Scene::new(self.origin, Arc::new(geometry), Arc::new(shading)))
    }
}
