//! The names of objects, materials and nodes of model files, as Cryptomatte shows them.

use super::{ObjectId, Scene};

/// An index into the scene's nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeId(pub u32);

/// A node of a model file's hierarchy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeName {
    /// May be empty.
    pub name: String,
    /// `None` at the top of the hierarchy.
    pub parent: Option<NodeId>,
}

impl Scene {
    /// The object of the scene file that an object is or belongs to.
    pub fn whole_object(&self, object: ObjectId) -> ObjectId {
        self.geometry.objects[object.0 as usize].part_of.unwrap_or(object)
    }

    /// The names of a node and its ancestors, from the root, separated by slashes. An unnamed node gets its number.
    pub fn node_path(&self, node: NodeId) -> String {
        let mut path = Vec::new();
        let mut next = Some(node);
        while let Some(id) = next {
            path.push(self.node_name(id));
            next = self.geometry.nodes[id.0 as usize].parent;
        }
        path.reverse();
        path.join("/")
    }

    /// The name of a node, or its number.
    pub fn node_name(&self, node: NodeId) -> String {
        match self.geometry.nodes[node.0 as usize].name.as_str() {
            "" => format!("node {}", node.0),
            name => name.to_owned(),
        }
    }

    /// The file of an object's geometry, or the object's own name if there is no file.
    pub fn asset_name(&self, object: ObjectId) -> &str {
        let object = &self.geometry.objects[object.0 as usize];
        object.asset.as_ref().unwrap_or(&object.name)
    }

    /// The name of an object, with the path of one of its nodes: `guard/Root/Visor`.
    pub fn part_name(&self, object: ObjectId, node: Option<NodeId>) -> String {
        let name = &self.geometry.objects[object.0 as usize].name;
        match node {
            Some(node) => format!("{name}/{}", self.node_path(node)),
            None => name.clone(),
        }
    }
}
