//! Updates of a scene between two frames of an animation.
//!
//! A scene is compiled once. [`Scene::apply`] changes it for another frame and rebuilds only what
//! the change requires: a moved object rebuilds the top level of the acceleration structure, a
//! deformed mesh its own tree. The picture is the same as that of a scene which was built for the
//! frame.
//!
//! Shapes and instances ([`super::SceneBuilder::instance`]) can be moved; a mesh that is baked into world space can only be
//! deformed.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use super::{Lights, MeshRecord, ObjectFromGroup, ObjectId, Scene, ShadingUpdate, builder::GroupId};
use crate::{
    accel::UpdateReport,
    geometry::{BuildError, Edit, InstanceId, MeshGroup},
    material::MaterialId,
    math::{Transform, Vec3, Vec4},
};

/// An index into [`SceneGeometry::meshes`](super::SceneGeometry::meshes).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshId(pub u32);

/// New vertex positions, normals and tangents of a mesh.
#[derive(Clone, Debug)]
pub struct MeshPose {
    pub mesh: MeshId,
    /// One for each vertex, in the space of the mesh's group, or in world space if it has none.
    pub positions: Vec<Vec3>,
    /// Unit shading normals in the same space, one for each vertex; empty if the mesh has none.
    pub normals: Vec<Vec3>,
    /// Tangents in the same space, one for each vertex; empty if the mesh has none.
    pub tangents: Vec<Vec4>,
}

/// The changes for a frame.
#[derive(Clone, Debug, Default)]
pub struct SceneUpdate {
    /// The new transforms of objects, for all of their shapes and instances, into the space around [`Scene::origin`].
    pub transforms: Vec<(ObjectId, Transform)>,
    /// The new transforms of single instances into the same space.
    pub instances: Vec<(InstanceId, Transform)>,
    /// The new transforms of groups into the spaces of their objects, by the numbers of [`ObjectFromGroup::At`].
    pub places: Vec<(u32, Transform)>,
    pub poses: Vec<MeshPose>,
}

impl SceneUpdate {
    /// Whether nothing changes.
    pub fn is_empty(&self) -> bool {
        self.transforms.is_empty() && self.instances.is_empty() && self.places.is_empty() && self.poses.is_empty()
    }
}

/// The reason why an update failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneUpdateError {
    #[error("object {} cannot be moved: it has no shape or instance, or it has meshes that are baked into the world", .0.0)]
    NotMovable(ObjectId),
    #[error("there is no mesh {}", .0.0)]
    NoSuchMesh(MeshId),
    #[error("mesh {} has {vertices} vertices, not {found} {what}", mesh.0)]
    WrongLength {
        mesh: MeshId,
        vertices: usize,
        found: usize,
        what: &'static str,
    },
    #[error("no group has the place {0}")]
    NoSuchPlace(u32),
    #[error("what would change is shared with another scene")]
    Shared,
    #[error("the shading has {found} materials, and the geometry uses {expected}")]
    TooFewMaterials { found: usize, expected: usize },
    #[error(transparent)]
    Build(#[from] BuildError),
}

/// Whether a mesh is in world space, and in none of these groups, which are in the order of their triangles.
fn is_baked(mesh: &MeshRecord, groups: &[MeshGroup]) -> bool {
    let next = groups.partition_point(|group| group.triangles.end <= mesh.triangles.start);
    groups
        .get(next)
        .is_none_or(|group| group.triangles.start > mesh.triangles.start)
}

impl Scene {
    /// The meshes of a group.
    pub fn meshes_of(&self, group: GroupId) -> impl Iterator<Item = MeshId> {
        let group = &self.geometry.accel.geometry().groups[group.0 as usize];
        let at = |triangle: u32| self.geometry.meshes.partition_point(|m| m.triangles.start < triangle) as u32;
        (at(group.triangles.start)..at(group.triangles.end)).map(MeshId)
    }

    /// Applies an update to the geometry and reports what was rebuilt. On error the scene is unchanged.
    ///
    /// # Errors
    /// The update does not fit the scene, or the geometry is shared with another scene ([`Scene::with_shading`]).
    pub fn apply(&mut self, update: &SceneUpdate) -> Result<UpdateReport, SceneUpdateError> {
        let (edit, detached) = self.edit(update)?;
        let moves_lights = self.moves_emitters(update);
        let geometry = Arc::get_mut(&mut self.geometry).ok_or(SceneUpdateError::Shared)?;
        let updated = geometry.accel.update(&edit)?;
        for (instance, object_from_group) in detached {
            let place = geometry.object_transforms.len() as u32;
            geometry.object_transforms.push(object_from_group);
            geometry.instances[instance].object_from_group = ObjectFromGroup::At(place);
        }
        for (place, transform) in &update.places {
            geometry.object_transforms[*place as usize] = *transform;
        }
        if !edit.shapes.is_empty() {
            let moved = edit.shapes.iter().map(|(shape, _)| *shape);
            geometry.contacts = geometry.contacts.after_moves(geometry.accel.geometry(), moved);
        }
        for pose in &update.poses {
            let mesh = &mut geometry.meshes[pose.mesh.0 as usize];
            mesh.normals.clone_from(&pose.normals);
            mesh.tangents.clone_from(&pose.tangents);
        }
        if moves_lights {
            self.lights = self.lights.renewed(&self.geometry, &self.shading);
        }
        Ok(updated)
    }

    /// Replaces values of the shading. Builds no acceleration structure, and the lights only if something that shines changes. On
    /// error the scene is unchanged.
    ///
    /// # Errors
    /// The shading is shared with another scene.
    ///
    /// # Panics
    /// There is no such material, texture or light.
    pub fn reshade(&mut self, update: ShadingUpdate) -> Result<(), SceneUpdateError> {
        let shading = Arc::get_mut(&mut self.shading).ok_or(SceneUpdateError::Shared)?;
        let mut shines = !update.lights.is_empty() || update.background.is_some();
        for (id, material) in &update.materials {
            shines |= material.emission().is_some() || shading.material(*id).emission().is_some();
        }
        // The light of textured emitters and lamps depends on their textures.
        let is_textured = self.lights.emitters().count() > 0 || self.lights.has_pictures();
        let changes_textures = !update.textures.is_empty();
        shines |= changes_textures && is_textured;
        shading.update(update);
        if shines {
            self.lights = if changes_textures {
                Lights::new(&self.geometry, &self.shading)
            } else {
                self.lights.renewed(&self.geometry, &self.shading)
            };
        }
        Ok(())
    }

    /// Whether an update moves a surface that emits. Those of instances are no lights.
    fn moves_emitters(&self, update: &SceneUpdate) -> bool {
        let emits = |material| self.material(material).emission().is_some();
        let geometry = &self.geometry;
        let moved = update.transforms.iter().map(|(object, _)| *object);
        let is_of = |object: ObjectId| geometry.shape_objects.contains(&object);
        let shapes = moved.filter(|object| emits(geometry.objects[object.0 as usize].material));
        let meshes = update.poses.iter().map(|pose| &geometry.meshes[pose.mesh.0 as usize]);
        self.lights.emitters().count() > 0
            && (shapes.into_iter().any(is_of) || meshes.into_iter().any(|mesh| emits(mesh.material)))
    }

    /// Gives all parts of an object another material. Builds no acceleration structure, and the lights only if one of the materials
    /// shines. On error the scene is unchanged.
    ///
    /// # Errors
    /// The geometry is shared with another scene.
    pub fn paint(&mut self, object: ObjectId, material: MaterialId) -> Result<(), SceneUpdateError> {
        let geometry = Arc::get_mut(&mut self.geometry).ok_or(SceneUpdateError::Shared)?;
        let old = std::mem::replace(&mut geometry.objects[object.0 as usize].material, material);
        for record in geometry.instances.iter_mut().filter(|record| record.object == object) {
            record.material = Some(material);
        }
        let groups = &geometry.accel.geometry().groups;
        let own = geometry.meshes.iter_mut().filter(|mesh| mesh.object == object);
        for mesh in own.filter(|mesh| is_baked(mesh, groups)) {
            mesh.material = material;
        }
        if [old, material]
            .iter()
            .any(|id| self.shading.material(*id).emission().is_some())
        {
            self.lights = self.lights.renewed(&self.geometry, &self.shading);
        }
        Ok(())
    }

    /// Returns the change of the geometry, and the instances whose object's space is no longer world space, with the transform
    /// to that space.
    fn edit(&self, update: &SceneUpdate) -> Result<(Edit, Vec<(usize, Transform)>), SceneUpdateError> {
        let mut edit = Edit::default();
        let mut detached = Vec::new();
        for pose in &update.poses {
            edit.vertices.push(self.checked(pose)?);
        }
        let geometry = self.geometry.accel.geometry();
        let baked = self
            .geometry
            .meshes
            .iter()
            .filter(|mesh| is_baked(mesh, &geometry.groups));
        let baked: HashSet<u32> = baked.map(|mesh| mesh.object.0).collect();
        if let Some((object, _)) = update.transforms.iter().find(|(object, _)| baked.contains(&object.0)) {
            return Err(SceneUpdateError::NotMovable(*object));
        }
        let mut moved: HashMap<u32, (Transform, bool)> =
            update.transforms.iter().map(|(o, t)| (o.0, (*t, false))).collect();
        for (shape, object) in (0..).zip(&self.geometry.shape_objects) {
            if let Some((transform, found)) = moved.get_mut(&object.0) {
                edit.shapes.push((shape, *transform));
                *found = true;
            }
        }
        for (number, record) in self.geometry.instances.iter().enumerate() {
            let Some((world_from_object, found)) = moved.get_mut(&record.object.0) else {
                continue;
            };
            *found = true;
            let instance = InstanceId(number as u32);
            let object_from_group = match record.object_from_group {
                ObjectFromGroup::Identity => None,
                ObjectFromGroup::At(place) => Some(self.geometry.object_transforms[place as usize]),
                ObjectFromGroup::WorldFromGroup => {
                    let place = *geometry.place(instance).expect("every instance stands somewhere");
                    detached.push((number, place));
                    Some(place)
                }
            };
            let singular = BuildError::InstanceTooLarge { instance: number };
            let transform = match object_from_group {
                None => *world_from_object,
                Some(t) => world_from_object.then_from(&t).ok_or(singular)?,
            };
            edit.instances.push((instance, transform));
        }
        edit.instances.extend(&update.instances);
        if let Some((place, _)) =
            (update.places.iter()).find(|(p, _)| *p as usize >= self.geometry.object_transforms.len())
        {
            return Err(SceneUpdateError::NoSuchPlace(*place));
        }
        match update.transforms.iter().find(|(object, _)| !moved[&object.0].1) {
            Some((object, _)) => Err(SceneUpdateError::NotMovable(*object)),
            None => Ok((edit, detached)),
        }
    }

    /// Validates a pose; returns its first vertex and the new positions.
    fn checked(&self, pose: &MeshPose) -> Result<(u32, Vec<Vec3>), SceneUpdateError> {
        let mesh = self.geometry.meshes.get(pose.mesh.0 as usize);
        let mesh = mesh.ok_or(SceneUpdateError::NoSuchMesh(pose.mesh))?;
        let vertices = mesh.vertices.len();
        let of = |is_empty: bool| if is_empty { 0 } else { vertices };
        let lengths = [
            ("positions", pose.positions.len(), vertices),
            ("normals", pose.normals.len(), of(mesh.normals.is_empty())),
            ("tangents", pose.tangents.len(), of(mesh.tangents.is_empty())),
        ];
        match lengths.into_iter().find(|(_, found, wanted)| found != wanted) {
            Some((what, found, _)) => Err(SceneUpdateError::WrongLength {
                mesh: pose.mesh,
                vertices,
                found,
                what,
            }),
            None => Ok((mesh.vertices.start, pose.positions.clone())),
        }
    }
}
