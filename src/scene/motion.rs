//! The motion of surfaces from frame to frame: where the point of a first hit is in the frames before and after.

use std::{collections::HashMap, ops::Range};

use super::{FirstHit, ObjectId, Scene};
use crate::{
    geometry::{Geometry, InstanceId},
    math::{Transform, Vec3},
};

/// The places of all surfaces of a scene at one time.
#[derive(Clone, Debug)]
pub struct ScenePlaces {
    transforms: Vec<Transform>,
    /// The index of the transform of each instance and of each shape.
    instances: Vec<u32>,
    shapes: Vec<Option<u32>>,
    /// In the space of their group; empty where they are the same at all times.
    vertices: Vec<Vec3>,
    owners: Owners,
}

/// The objects of instances, shapes and meshes. An object that is not visible has none.
#[derive(Clone, Debug, PartialEq)]
struct Owners {
    instances: Vec<ObjectId>,
    shapes: Vec<ObjectId>,
    meshes: Vec<ObjectId>,
    /// The vertices of each mesh.
    vertices: Vec<Range<u32>>,
}

impl ScenePlaces {
    pub fn new(scene: &Scene) -> Self {
        let geometry = scene.geometry.accel.geometry();
        Self {
            transforms: geometry.transforms.clone(),
            instances: geometry.instances.iter().map(|placed| placed.transform).collect(),
            shapes: geometry.shapes.iter().map(|placed| placed.transform).collect(),
            vertices: geometry.vertices.clone(),
            owners: Owners {
                instances: scene
                    .geometry
                    .instances
                    .iter()
                    .map(|instance| instance.object)
                    .collect(),
                shapes: scene.geometry.shape_objects.clone(),
                meshes: scene.geometry.meshes.iter().map(|mesh| mesh.object).collect(),
                vertices: scene.geometry.meshes.iter().map(|mesh| mesh.vertices.clone()).collect(),
            },
        }
    }

    /// These places in the order of `now`, in which other objects may be visible. What has no counterpart counts as unmoved.
    fn in_order_of(self, now: &Self) -> Self {
        if self.owners == now.owners {
            return self;
        }
        let mut ordered = now.clone();
        for (own, other) in counterparts(&now.owners.instances, &self.owners.instances) {
            ordered.instances[own] = now.transforms.len() as u32 + self.instances[other];
        }
        for (own, other) in counterparts(&now.owners.shapes, &self.owners.shapes) {
            ordered.shapes[own] = self.shapes[other].map(|index| now.transforms.len() as u32 + index);
        }
        for (own, other) in counterparts(&now.owners.meshes, &self.owners.meshes) {
            let [own, other] = [(now, own), (&self, other)].map(|(places, mesh)| {
                let Range { start, end } = places.owners.vertices[mesh];
                start as usize..end as usize
            });
            if own.len() == other.len() {
                ordered.vertices[own].copy_from_slice(&self.vertices[other]);
            }
        }
        ordered.transforms.extend(self.transforms);
        ordered
    }

    /// The transform of the instance or the shape of a hit to the world.
    fn transform(&self, geometry: &Geometry, hit: &FirstHit) -> Option<Transform> {
        let index = match (hit.prim.index() as usize).checked_sub(geometry.triangles.len()) {
            Some(shape) => *self.shapes.get(shape)?,
            None => self.instances.get(hit.instance.0 as usize).copied(),
        };
        self.transforms.get(index? as usize).copied()
    }

    /// The corners of the triangle of a hit, unless they are the same at all times.
    fn corners(&self, geometry: &Geometry, hit: &FirstHit) -> Option<[Vec3; 3]> {
        let corners = geometry.triangles.get(hit.prim.index() as usize)?;
        let [a, b, c] = corners.map(|v| self.vertices.get(v as usize).copied());
        Some([a?, b?, c?])
    }

    /// The place of the point of a first hit of `scene`, which shows the same objects at another time.
    fn point(&self, scene: &Scene, hit: &FirstHit) -> Vec3 {
        let geometry = scene.geometry.accel.geometry();
        let from = match geometry.shape(hit.prim) {
            Some(placed) => geometry.transform(placed),
            None if hit.instance == InstanceId::NONE => None,
            None => geometry.place(hit.instance),
        };
        let to = self.transform(geometry, hit);
        let corners = self.corners(geometry, hit);
        let corners = corners.filter(|corners| *corners != geometry.corners(hit.prim.index() as usize));
        if from == to.as_ref() && corners.is_none() {
            return hit.p;
        }
        let local = match corners {
            Some([a, b, c]) => {
                let [u, v] = hit.barycentric;
                a * (1.0 - u - v) + b * u + c * v
            }
            None => from.map_or(hit.p, |from| from.point_to_local(hit.p)),
        };
        to.map_or(local, |to| to.point_to_world(local))
    }
}

/// The indices of the parts of each object in two lists of their owners, where an object has as many in both.
fn counterparts(now: &[ObjectId], other: &[ObjectId]) -> Vec<(usize, usize)> {
    let by_object = |owners: &[ObjectId]| {
        let mut parts = HashMap::<u32, Vec<usize>>::new();
        for (i, owner) in owners.iter().enumerate() {
            parts.entry(owner.0).or_default().push(i);
        }
        parts
    };
    let (now, other) = (by_object(now), by_object(other));
    let pairs = now.iter().filter_map(|(object, own)| Some((own, other.get(object)?)));
    let alike = pairs.filter(|(own, other)| own.len() == other.len());
    alike
        .flat_map(|(own, other)| own.iter().copied().zip(other.iter().copied()))
        .collect()
}

/// The places of all surfaces as the shutters of a frame and of its neighbours open.
#[derive(Clone, Debug)]
pub struct SceneMotion {
    before: Option<ScenePlaces>,
    now: ScenePlaces,
    after: Option<ScenePlaces>,
}

/// The places of the point of a first hit as the shutters of a frame and of its neighbours open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMotion {
    pub before: Vec3,
    pub now: Vec3,
    pub after: Vec3,
}

impl SceneMotion {
    /// The motion between these places.
    pub fn new(before: Option<ScenePlaces>, mut now: ScenePlaces, after: Option<ScenePlaces>) -> Self {
        let [mut before, mut after] = [before, after].map(|places| places.map(|places| places.in_order_of(&now)));
        let mut neighbours = before.iter_mut().chain(&mut after);
        if neighbours.by_ref().all(|places| places.vertices == now.vertices) {
            now.vertices = Vec::new();
            for places in before.iter_mut().chain(&mut after) {
                places.vertices = Vec::new();
            }
        }
        Self { before, now, after }
    }

    /// The motion of the point of a first hit of `scene`, which is the frame's scene while the shutter is open.
    pub fn of(&self, scene: &Scene, hit: &FirstHit) -> PointMotion {
        let now = self.now.point(scene, hit);
        let neighbour = |places: Option<&ScenePlaces>| places.map_or(now, |places| places.point(scene, hit));
        PointMotion {
            before: neighbour(self.before.as_ref()),
            now,
            after: neighbour(self.after.as_ref()),
        }
    }
}
