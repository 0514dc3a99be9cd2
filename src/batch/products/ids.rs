//! The content of `ids.json`: the names of what the passes of numbers show.

use std::{
    borrow::Cow,
    collections::{HashMap, HashSet},
};

use serde::{Deserialize, Serialize};

use crate::{
    math::sorting,
    scene::{MatteKind, NodeId, Part, Scene},
};

/// Names in the order of their numbers, of which the first is 1, and the tree of the objects.
#[derive(PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Names {
    object_id: Vec<String>,
    material_id: Vec<String>,
    instance_id: Vec<String>,
    tree: Vec<Branch>,
}

/// The file of a job whose frames have the same names.
#[derive(Serialize)]
pub(super) struct Ids {
    conventions: &'static str,
    #[serde(flatten)]
    names: Names,
}

/// The file of a job whose frames show different models: their names, each with the frames that have them.
#[derive(Serialize, Deserialize)]
pub(super) struct IdsOfFrames {
    conventions: Cow<'static, str>,
    tables: Vec<Table>,
}

#[derive(Serialize, Deserialize)]
struct Table {
    frames: Vec<i32>,
    #[serde(flatten)]
    names: Names,
}

/// The names of frames so far.
#[derive(Default)]
pub(super) struct NamesOfFrames(Vec<Table>);

const CONVENTIONS: &str = "the first name has the number 1; 0 is nothing; instanceId names the object of each copy; \
                           parent and children are places in tree, from 0, and id is the number in objectId";

/// An object or a node of its model file. Branches refer to each other by their places in the list, from 0, so that a file
/// with deep nodes is as easy to read as others.
#[derive(PartialEq, Serialize, Deserialize)]
struct Branch {
    name: String,
    /// The number in `objectId`; a node without geometry has none.
    id: Option<usize>,
    parent: Option<usize>,
    children: Vec<usize>,
}

impl Ids {
    pub fn new(scene: &Scene) -> Self {
        Self {
            conventions: CONVENTIONS,
            names: Names::new(scene),
        }
    }
}

impl Names {
    pub fn new(scene: &Scene) -> Self {
        let mattes = scene.mattes();
        let object_id: Vec<String> = mattes.parts().iter().map(|part| scene.name_of(part)).collect();
        let materials = mattes.table(MatteKind::Material).mattes.iter();
        Self {
            instance_id: mattes
                .parts_of_copies(scene)
                .into_iter()
                .map(|part| object_id[part as usize].clone())
                .collect(),
            tree: tree(scene, mattes.parts()),
            object_id,
            material_id: materials.map(|matte| matte.name.clone()).collect(),
        }
    }
}

impl NamesOfFrames {
    pub fn add(&mut self, frame: i32, names: Names) {
        add(
            &mut self.0,
            Table {
                frames: vec![frame],
                names,
            },
        );
    }

    /// The file of those of these frames that are on disk.
    pub fn file(self, done: &HashSet<i32>) -> IdsOfFrames {
        let mut file = IdsOfFrames {
            conventions: format!("frames lists those that a table is for; {CONVENTIONS}").into(),
            tables: self.0,
        };
        file.retain(|frame| done.contains(&frame));
        file
    }
}

/// Adds the frames of a table to those of the same names.
fn add(tables: &mut Vec<Table>, other: Table) {
    match tables.iter_mut().find(|table| table.names == other.names) {
        Some(table) => table.frames.extend(other.frames),
        None => tables.push(other),
    }
}

impl IdsOfFrames {
    /// Adds the frames of other jobs of the same sequence, whose pictures are named by `picture`.
    /// Pictures of this job replace theirs.
    pub fn join(&mut self, mut others: Self, picture: impl Fn(i32) -> String) {
        let frames = self.tables.iter().flat_map(|table| &table.frames);
        let own: HashSet<String> = frames.map(|frame| picture(*frame)).collect();
        others.retain(|frame| !own.contains(&picture(frame)));
        others.tables.into_iter().for_each(|table| add(&mut self.tables, table));
        self.retain(|_| true);
    }

    /// Keeps some of the frames, in rising order, and the tables that they have, in the order of their first frames.
    fn retain(&mut self, is_kept: impl Fn(i32) -> bool) {
        for table in &mut self.tables {
            table.frames.retain(|frame| is_kept(*frame));
            table.frames.sort_unstable();
        }
        self.tables.retain(|table| !table.frames.is_empty());
        sorting::sort_by_key(&mut self.tables, |table| table.frames[0]);
    }
}

/// The parts below their objects and nodes, each after its parent.
fn tree(scene: &Scene, parts: &[Part]) -> Vec<Branch> {
    let (mut tree, mut known) = (Vec::new(), HashMap::new());
    for (i, part) in parts.iter().enumerate() {
        let object = &scene.geometry.objects[part.object.0 as usize];
        let mut path = vec![(None, object.name.clone())];
        path.extend(ancestors(scene, part.node).map(|node| (Some(node.0), scene.node_name(node))));
        let mut parent = None;
        for (node, name) in path {
            let at = *known.entry((part.object.0, node)).or_insert_with(|| {
                tree.push(Branch {
                    name,
                    id: None,
                    parent,
                    children: Vec::new(),
                });
                tree.len() - 1
            });
            parent = Some(at);
        }
        if let Some(at) = parent {
            tree[at].id = Some(i + 1);
        }
    }
    for child in 0..tree.len() {
        if let Some(parent) = tree[child].parent {
            tree[parent].children.push(child);
        }
    }
    tree
}

/// The node and those above it, from the root.
fn ancestors(scene: &Scene, node: Option<NodeId>) -> impl Iterator<Item = NodeId> {
    let parent = |node: &NodeId| scene.geometry.nodes[node.0 as usize].parent;
    let path: Vec<NodeId> = std::iter::successors(node, parent).collect();
    path.into_iter().rev()
}
