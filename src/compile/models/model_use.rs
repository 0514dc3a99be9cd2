//! The use of a model by the objects of a scene.

use std::collections::HashMap;

use crate::{assets::model::MeshInstance, material::MaterialId, scene::NodeId};

/// The use of a model by the objects of a scene.
#[derive(Default)]
pub struct ModelUse {
    pub objects: u64,
    /// Its first material in the scene, once an object uses them.
    pub first_material: Option<MaterialId>,
    /// The materials of the scene in place of some of its own, by their indices.
    pub replaced: HashMap<usize, MaterialId>,
    pub first_node: Option<NodeId>,
}

impl ModelUse {
    /// Returns the use by a part of the model, which shares materials and nodes with it.
    pub fn shared(&self) -> Self {
        Self {
            objects: 0,
            replaced: self.replaced.clone(),
            ..*self
        }
    }

    /// The material with this index in the model, or `instead`.
    pub fn material(&self, number: usize, instead: Option<MaterialId>) -> MaterialId {
        let first = self.first_material.map_or(0, |m| m.0);
        let other = instead.or_else(|| self.replaced.get(&number).copied());
        other.unwrap_or(MaterialId(first + number as u32))
    }

    pub fn node_of(&self, part: &MeshInstance) -> Option<NodeId> {
        let first = self.first_node?;
        part.node.map(|node| NodeId(first.0 + node as u32))
    }
}
