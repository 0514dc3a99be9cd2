//! The mattes of a scene: unique names of its objects, materials and files, with their Cryptomatte ids.
//!
//! An object from a model file has a matte for each node with geometry, `object/node/node`; the nodes of an OBJ file are its
//! objects and groups. A name that is not unique, or whose id is not, gets `#2`, `#3` and so on: several models may use the
//! same name for a material, and among 200,000 names two probably have the same hash.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    ops::Range,
    sync::Arc,
};

use super::{FirstHit, NodeId, ObjectId, Scene};
use crate::{
    geometry::InstanceId,
    math::{hash, sorting},
};

/// The limit of node names of all instances together; instances beyond it get the names of their objects.
const MAX_INSTANCE_NODES: usize = 1 << 20;

/// The kind of thing that a matte stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatteKind {
    /// An object, or a node of its model file.
    Object,
    Material,
    /// The file of the geometry, or the object if there is no file.
    Asset,
}

/// A name with its id: a hash whose bits are a normal float, hence never 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Matte {
    pub name: String,
    pub id: u32,
}

/// The mattes of one kind; names and ids are unique.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MatteTable {
    pub mattes: Vec<Matte>,
}

/// All mattes of a scene, and those of each surface.
#[derive(Debug)]
pub struct Mattes {
    objects: Arc<MatteTable>,
    materials: Arc<MatteTable>,
    assets: Arc<MatteTable>,
    /// The matte of each shape, and of each mesh in no group.
    shapes: Vec<u32>,
    meshes: Vec<u32>,
    instances: Vec<InstanceMattes>,
    /// The mattes of all instances, concatenated.
    of_instances: Vec<u32>,
    /// The index of each mesh within its group.
    in_group: Vec<u32>,
    of_materials: Vec<u32>,
    of_objects: Vec<u32>,
    /// See [`Mattes::parts`].
    parts: Vec<Part>,
    /// The index of the part of each matte of an object.
    part_of: Vec<u32>,
}

/// An object, or a node of its model file, as the pass `objectId` counts them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    pub object: ObjectId,
    pub node: Option<NodeId>,
    /// The index of its matte; `None` where it has nothing to see.
    pub matte: Option<u32>,
}

#[derive(Clone, Copy, Debug)]
struct InstanceMattes {
    /// The index of its first matte in `of_instances`.
    first: u32,
    /// Whether each mesh of its group has a matte of its own.
    is_by_mesh: bool,
}

impl Mattes {
    pub(super) fn new(scene: &Scene) -> Self {
        let material = |(i, name): (usize, &String)| match name.as_str() {
            "" => format!("material {}", i + 1),
            name => name.to_owned(),
        };
        let (mut materials, mut assets) = (TableBuilder::default(), AssetMattes::default());
        let of_materials = scene.shading.material_names.iter().enumerate().map(material);
        let of_materials = of_materials.map(|name| materials.add(&name)).collect();
        let of_objects = (0..scene.geometry.objects.len())
            .map(|i| assets.add(scene, i))
            .collect();
        let mut objects = ObjectMattes::new(scene);
        for (object, node) in &scene.geometry.named_nodes {
            objects.add(*object, Some(*node));
        }
        let geometry = scene.geometry.accel.geometry();
        let meshes_of = |group: u32| scene.meshes_within(&geometry.groups[group as usize].triangles);
        let mut in_group = vec![None; scene.geometry.meshes.len()];
        for group in 0..geometry.groups.len() as u32 {
            for (number, mesh) in meshes_of(group).enumerate() {
                in_group[mesh] = Some(number as u32);
            }
        }
        let shapes = scene.geometry.shape_objects.iter();
        let shapes = shapes.map(|object| objects.add(*object, None)).collect();
        let meshes = scene
            .geometry
            .meshes
            .iter()
            .zip(&in_group)
            .map(|(mesh, in_group)| match in_group {
                None => objects.add(mesh.object, mesh.node),
                Some(_) => 0,
            });
        let meshes: Vec<u32> = meshes.collect();
        let mut of_instances = Vec::new();
        let instances = scene
            .geometry
            .instances
            .iter()
            .zip(&geometry.instances)
            .map(|(record, place)| {
                let (first, own) = (of_instances.len(), meshes_of(place.group));
                let is_by_mesh = record.node.is_none() && first + own.len() <= MAX_INSTANCE_NODES;
                if is_by_mesh {
                    of_instances.extend(own.map(|mesh| objects.add(record.object, scene.geometry.meshes[mesh].node)));
                } else {
                    of_instances.push(objects.add(record.object, record.node));
                }
                InstanceMattes {
                    first: first as u32,
                    is_by_mesh,
                }
            });
        let instances = instances.collect();
        for (object, node) in &scene.geometry.hidden {
            objects.add(*object, *node);
        }
        let (table, places) = objects.finish(scene);
        let (parts, part_of) = objects.parts(&places, scene.geometry.objects.len());
        let place = |matte: u32| places.get(matte as usize).copied().unwrap_or_default();
        let placed = |mattes: Vec<u32>| mattes.into_iter().map(place).collect();
        Self {
            parts,
            part_of,
            shapes: placed(shapes),
            meshes: placed(meshes),
            instances,
            of_instances: placed(of_instances),
            in_group: in_group.into_iter().map(Option::unwrap_or_default).collect(),
            of_materials,
            of_objects,
            objects: Arc::new(table),
            materials: Arc::new(materials.finish()),
            assets: Arc::new(assets.table.finish()),
        }
    }

    /// All mattes of a kind.
    pub fn table(&self, kind: MatteKind) -> &Arc<MatteTable> {
        match kind {
            MatteKind::Object => &self.objects,
            MatteKind::Material => &self.materials,
            MatteKind::Asset => &self.assets,
        }
    }

    /// The id of the matte at a hit of `scene`.
    pub fn id(&self, kind: MatteKind, scene: &Scene, hit: &FirstHit) -> u32 {
        let matte = match kind {
            MatteKind::Object => self.object(scene, hit),
            MatteKind::Material => self.of_materials[hit.material.0 as usize],
            MatteKind::Asset => self.of_objects[hit.object.0 as usize],
        };
        self.table(kind).mattes[matte as usize].id
    }

    /// All parts of all objects, in the order of the objects.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The index of the part at a hit of `scene`.
    pub fn part(&self, scene: &Scene, hit: &FirstHit) -> u32 {
        self.part_of[self.object(scene, hit) as usize]
    }

    /// The index of the part of each copy of a mesh, in the order of their numbers.
    pub fn parts_of_copies(&self, scene: &Scene) -> Vec<u32> {
        let groups = &scene.geometry.accel.geometry().groups;
        let (records, places) = (&scene.geometry.instances, &scene.geometry.accel.geometry().instances);
        let mut is_in_group = vec![false; self.meshes.len()];
        let mut found: BTreeMap<u32, u32> = BTreeMap::new();
        for (i, (record, place)) in records.iter().zip(places).enumerate() {
            for mesh in scene.meshes_within(&groups[place.group as usize].triangles) {
                is_in_group[mesh] = true;
                if let Some(copy) = scene.geometry.meshes[mesh].copy {
                    found
                        .entry(record.first_copy + copy)
                        .or_insert(self.of_instance(i, mesh));
                }
            }
        }
        for (mesh, record) in scene.geometry.meshes.iter().enumerate() {
            if let Some(copy) = record.copy.filter(|_| !is_in_group[mesh]) {
                found.entry(copy).or_insert(self.meshes[mesh]);
            }
        }
        let count = found.last_key_value().map_or(0, |(last, _)| last + 1);
        // A copy without area has no mesh, and stands beside the one before it.
        let before = |copy| found.range(..=copy).next_back().or(found.first_key_value());
        let parts = (0..count).filter_map(before);
        parts.map(|(_, matte)| self.part_of[*matte as usize]).collect()
    }

    /// The matte of a mesh in an instance.
    fn of_instance(&self, instance: usize, mesh: usize) -> u32 {
        let InstanceMattes { first, is_by_mesh } = self.instances[instance];
        self.of_instances[(first + if is_by_mesh { self.in_group[mesh] } else { 0 }) as usize]
    }

    fn object(&self, scene: &Scene, hit: &FirstHit) -> u32 {
        let triangles = scene.geometry.accel.geometry().triangles.len();
        if let Some(shape) = (hit.prim.index() as usize).checked_sub(triangles) {
            return self.shapes[shape];
        }
        let mesh = scene.geometry.mesh_index(hit.prim);
        match hit.instance {
            InstanceId::NONE => self.meshes[mesh],
            InstanceId(instance) => self.of_instance(instance as usize, mesh),
        }
    }
}

impl Scene {
    /// The mattes of the scene, which are made at the first call.
    pub fn mattes(&self) -> &Mattes {
        self.mattes.get_or_init(|| Mattes::new(self))
    }

    /// The name of a part, which no other has where it has something to see.
    pub fn name_of(&self, part: &Part) -> String {
        match part.matte {
            Some(matte) => self.mattes().objects.mattes[matte as usize].name.clone(),
            None => self.part_name(part.object, part.node),
        }
    }

    /// The number, from 0, of the copy of a mesh at a hit; `None` where that is shown once, or is no mesh.
    pub fn copy(&self, hit: &FirstHit) -> Option<u32> {
        let copy = self.geometry.mesh_of(hit.prim)?.copy?;
        let instance = self.geometry.instances.get(hit.instance.0 as usize);
        Some(copy + instance.map_or(0, |instance| instance.first_copy))
    }

    /// The indices of the meshes of these triangles.
    fn meshes_within(&self, triangles: &Range<u32>) -> Range<usize> {
        let from = |triangle| self.geometry.meshes.partition_point(|m| m.triangles.start < triangle);
        from(triangles.start)..from(triangles.end)
    }
}

/// The mattes of objects and their nodes, in the order of their first use.
struct ObjectMattes<'a> {
    scene: &'a Scene,
    keys: Vec<(ObjectId, Option<NodeId>)>,
    known: HashMap<(u32, Option<u32>), u32>,
}

impl<'a> ObjectMattes<'a> {
    fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            keys: Vec::new(),
            known: HashMap::new(),
        }
    }

    /// The number of an object's node, by its first use.
    fn add(&mut self, object: ObjectId, node: Option<NodeId>) -> u32 {
        let object = self.scene.whole_object(object);
        let keys = &mut self.keys;
        let key = (object.0, node.map(|node| node.0));
        *self.known.entry(key).or_insert_with(|| {
            keys.push((object, node));
            keys.len() as u32 - 1
        })
    }

    /// All mattes in the order of their objects, so that they are the same whichever of these are visible, and the place of each
    /// number among them.
    fn finish(&self, scene: &Scene) -> (MatteTable, Vec<u32>) {
        let mut order: Vec<usize> = (0..self.keys.len()).collect();
        sorting::sort_by_key(&mut order, |number| self.keys[*number].0.0);
        let (mut table, mut places) = (TableBuilder::default(), vec![0; self.keys.len()]);
        for number in order {
            let (object, node) = self.keys[number];
            places[number] = table.add(&scene.part_name(object, node));
        }
        (table.finish(), places)
    }

    /// The parts of this many objects, in their order, and the index of the part of each matte, where `places` are those of
    /// [`ObjectMattes::finish`].
    fn parts(&self, places: &[u32], objects: usize) -> (Vec<Part>, Vec<u32>) {
        let seen = self.keys.iter().zip(places).map(|((object, node), place)| Part {
            object: *object,
            node: *node,
            matte: Some(*place),
        });
        let mut parts: Vec<Part> = seen.collect();
        let visible: HashSet<u32> = parts.iter().map(|part| part.object.0).collect();
        let is_whole = |object: &u32| self.scene.whole_object(ObjectId(*object)) == ObjectId(*object);
        let unseen = (0..objects as u32).filter(|object| is_whole(object) && !visible.contains(object));
        parts.extend(unseen.map(|object| Part {
            object: ObjectId(object),
            node: None,
            matte: None,
        }));
        parts.sort_unstable_by_key(|part| (part.object.0, part.matte));
        let mut part_of = vec![0; self.keys.len()];
        for (index, part) in parts.iter().enumerate() {
            if let Some(matte) = part.matte {
                part_of[matte as usize] = index as u32;
            }
        }
        (parts, part_of)
    }
}

/// The mattes of files, and of objects without one.
#[derive(Default)]
struct AssetMattes {
    table: TableBuilder,
    files: HashMap<String, u32>,
}

impl AssetMattes {
    /// The number of the matte of an object's file.
    fn add(&mut self, scene: &Scene, object: usize) -> u32 {
        let object = &scene.geometry.objects[object];
        match &object.asset {
            None => self.table.add(&object.name),
            Some(file) => {
                let table = &mut self.table;
                *self.files.entry(file.clone()).or_insert_with(|| table.add(file))
            }
        }
    }
}

/// Makes names unique, and their ids.
#[derive(Default)]
struct TableBuilder {
    mattes: Vec<Matte>,
    names: HashSet<String>,
    ids: HashSet<u32>,
    /// The next suffix to try for each name that is not unique.
    next: HashMap<String, u32>,
}

impl TableBuilder {
    /// Adds a matte; returns its number.
    fn add(&mut self, wanted: &str) -> u32 {
        let mut name = wanted.to_owned();
        let mut id = hash::name_as_float(&name).to_bits();
        while self.names.contains(&name) || self.ids.contains(&id) {
            let number = self.next.entry(wanted.to_owned()).or_insert(2);
            name = format!("{wanted}#{number}");
            id = hash::name_as_float(&name).to_bits();
            *number += 1;
        }
        self.names.insert(name.clone());
        self.ids.insert(id);
        self.mattes.push(Matte { name, id });
        self.mattes.len() as u32 - 1
    }

    fn finish(self) -> MatteTable {
        MatteTable { mattes: self.mattes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_ids_are_unique_whatever_was_asked_for() {
        let mut table = TableBuilder::default();
        for name in ["steel", "steel", "steel#2", "steel", ""] {
            table.add(name);
        }
        let names: Vec<_> = table.mattes.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["steel", "steel#2", "steel#2#2", "steel#3", ""]);
        assert!(table.mattes.iter().all(|m| m.id != 0));
    }

    #[test]
    fn among_200_000_names_no_two_share_an_id() {
        let mut table = TableBuilder::default();
        for i in 0..200_000 {
            table.add(&format!("obj{i}"));
        }
        let changed = table.mattes.iter().filter(|m| m.name.contains('#')).count();
        assert!(changed > 0, "hashes of 32 bits collide");
        let ids: HashSet<u32> = table.mattes.iter().map(|m| m.id).collect();
        assert_eq!(ids.len(), 200_000);
    }
}
