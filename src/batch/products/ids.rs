//! The content of `ids.json`: the names of what the passes of numbers show.

use std::collections::HashMap;

use serde::Serialize;

use crate::scene::{MatteKind, NodeId, Part, Scene};

/// Names in the order of their numbers, of which the first is 1, and the tree of the objects.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Ids {
    conventions: &'static str,
    object_id: Vec<String>,
    material_id: Vec<String>,
    instance_id: Vec<String>,
    tree: Vec<Branch>,
}

/// An object or a node of its model file. Branches refer to each other by their places in the list, from 0, so that a file
/// with deep nodes is as easy to read as others.
#[derive(Serialize)]
struct Branch {
    name: String,
    /// The number in `objectId`; a node without geometry has none.
    id: Option<usize>,
    parent: Option<usize>,
    children: Vec<usize>,
}

impl Ids {
    pub fn new(scene: &Scene) -> Self {
        let mattes = scene.mattes();
        let names = |kind| mattes.table(kind).mattes.iter().map(|matte| matte.name.clone());
        let objects: Vec<String> = names(MatteKind::Object).collect();
        let name = |part: &Part| match part.matte {
            Some(matte) => objects[matte as usize].clone(),
            None => scene.part_name(part.object, part.node),
        };
        let object_id: Vec<String> = mattes.parts().iter().map(name).collect();
        Self {
            conventions: "the first name has the number 1; 0 is nothing; instanceId names the object of each copy; \
                          parent and children are places in tree, from 0, and id is the number in objectId",
            instance_id: mattes
                .parts_of_copies(scene)
                .into_iter()
                .map(|part| object_id[part as usize].clone())
                .collect(),
            tree: tree(scene, mattes.parts()),
            object_id,
            material_id: names(MatteKind::Material).collect(),
        }
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
