//! Scenes built in code, piece by piece.

use std::sync::Arc;

use super::{Background, InstanceRecord, LightGroups, Lights, MeshRecord, Object, ObjectFromGroup, ObjectId, Scene};
use crate::{
    accel::{self, BuildError, BuildOptions, Geometry, Group, PlacedGroup},
    light::Light,
    material::{Material, MaterialId},
    math::Transform,
    shape::{
        Shape,
        mesh::{Mesh, MeshError},
    },
    texture::{Bitmap, BitmapId, Texture, TextureId, mipmap},
};

/// Meshes that are stored once and stand in the scene as often as they are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GroupId(pub u32);

/// A scene in the making. What it gives out numbers for is named by them from then on.
#[derive(Clone, Debug)]
pub struct Builder {
    geometry: Geometry,
    objects: Vec<Object>,
    meshes: Vec<MeshRecord>,
    instances: Vec<InstanceRecord>,
    shape_objects: Vec<ObjectId>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    bitmaps: Vec<Bitmap>,
    lights: Vec<Light>,
    background: Background,
}

impl Builder {
    pub fn new(background: Background) -> Self {
        Self {
            geometry: Geometry::default(),
            objects: Vec::new(),
            meshes: Vec::new(),
            instances: Vec::new(),
            shape_objects: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            bitmaps: Vec::new(),
            lights: Vec::new(),
            background,
        }
    }

    pub fn bitmap(&mut self, bitmap: Bitmap) -> BitmapId {
        self.bitmaps.push(bitmap);
        BitmapId(self.bitmaps.len() as u32 - 1)
    }

    pub fn texture(&mut self, texture: Texture) -> TextureId {
        self.textures.push(texture);
        TextureId(self.textures.len() as u32 - 1)
    }

    pub fn material(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        MaterialId(self.materials.len() as u32 - 1)
    }

    pub fn light(&mut self, light: Light) {
        self.lights.push(light);
    }

    /// A shape at its place.
    pub fn shape(&mut self, name: &str, shape: Shape, transform: Option<Transform>, material: MaterialId) -> ObjectId {
        let object = self.object(name, material);
        self.geometry.add_shape(shape, transform);
        self.shape_objects.push(object);
        object
    }

    /// A mesh whose corners and normals are in world space.
    pub fn mesh(&mut self, name: &str, mesh: Mesh, material: MaterialId) -> Result<ObjectId, MeshError> {
        mesh.validate()?;
        let object = self.object(name, material);
        self.add_mesh(mesh, object, material);
        Ok(object)
    }

    /// Meshes in a space of their own, each with its material, for [`Builder::instance`].
    pub fn group(&mut self, meshes: Vec<(Mesh, MaterialId)>) -> Result<GroupId, MeshError> {
        meshes.iter().try_for_each(|(mesh, _)| mesh.validate())?;
        let (vertices, triangles) = (self.geometry.vertices.len(), self.geometry.triangles.len());
        for (mesh, material) in meshes {
            self.add_mesh(mesh, ObjectId(0), material);
        }
        self.geometry.groups.push(Group {
            triangles: triangles as u32..self.geometry.triangles.len() as u32,
            vertices: vertices as u32..self.geometry.vertices.len() as u32,
        });
        Ok(GroupId(self.geometry.groups.len() as u32 - 1))
    }

    /// A group at a place, as an object of its own that can be moved. Its meshes have `material` instead of their own
    /// where there is one.
    pub fn instance(
        &mut self,
        name: &str,
        group: GroupId,
        transform: Transform,
        material: Option<MaterialId>,
    ) -> ObjectId {
        let object = self.object(name, material.unwrap_or(MaterialId(0)));
        self.geometry.instances.push(PlacedGroup {
            group: group.0,
            transform: self.geometry.transforms.len() as u32,
        });
        self.geometry.transforms.push(transform);
        self.instances.push(InstanceRecord {
            object,
            material,
            object_from_group: ObjectFromGroup::Identity,
        });
        object
    }

    fn add_mesh(&mut self, mesh: Mesh, object: ObjectId, material: MaterialId) {
        let first_vertex = self.geometry.vertices.len() as u32;
        let first_triangle = self.geometry.triangles.len() as u32;
        self.geometry.vertices.extend(mesh.positions);
        let moved = mesh.triangles.iter().map(|t| t.map(|v| v + first_vertex));
        self.geometry.triangles.extend(moved);
        self.meshes.push(MeshRecord {
            object,
            material,
            transform: None,
            triangles: first_triangle..self.geometry.triangles.len() as u32,
            vertices: first_vertex..self.geometry.vertices.len() as u32,
            normals: mesh.normals,
            uvs: mesh.uvs,
        });
    }

    fn object(&mut self, name: &str, material: MaterialId) -> ObjectId {
        self.objects.push(Object {
            name: name.to_owned(),
            material,
        });
        ObjectId(self.objects.len() as u32 - 1)
    }

    /// The scene, with its acceleration structure.
    pub fn build(mut self, accel: impl Into<BuildOptions>) -> Result<Scene, BuildError> {
        mipmap::add_levels(&self.textures, &mut self.bitmaps);
        Ok(Scene {
            accel: accel::build(accel, Arc::new(self.geometry))?,
            objects: self.objects,
            meshes: self.meshes,
            instances: self.instances,
            object_places: Vec::new(),
            shape_objects: self.shape_objects,
            materials: self.materials,
            textures: self.textures,
            bitmaps: self.bitmaps,
            lights: Lights::default(),
            light_groups: LightGroups::default(),
            background: self.background,
            varying: Vec::new(),
        }
        .lit(self.lights))
    }
}
