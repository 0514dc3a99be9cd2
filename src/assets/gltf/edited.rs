//! The nodes and materials of a document of which values replace some.

use std::collections::{HashMap, HashSet};

use crate::assets::{model::Model, motion::EditedParts};

/// The nodes and materials of a document of which values replace some, by their numbers.
#[derive(Default)]
pub(super) struct EditedNumbers {
    /// The nodes by their names.
    nodes: HashMap<String, usize>,
    moved: HashSet<usize>,
    switched: HashSet<usize>,
    /// The materials with their names.
    pub materials: Vec<(usize, String)>,
}

impl EditedNumbers {
    /// The numbers of these parts of `model`, which has the names of all nodes and materials. Others are left out.
    pub fn new(edited: &EditedParts, model: &Model) -> Self {
        let mut numbers = Self::default();
        if edited.is_empty() {
            return numbers;
        }
        for (number, name) in model.names_of_nodes().into_iter().enumerate() {
            let (is_moved, is_switched) = (edited.moved.contains(&name), edited.switched.contains(&name));
            numbers.moved.extend(is_moved.then_some(number));
            numbers.switched.extend(is_switched.then_some(number));
            if is_moved || is_switched {
                numbers.nodes.insert(name, number);
            }
        }
        let names = model.names_of_materials().into_iter().map(|(name, _)| name);
        let materials = names.enumerate();
        numbers.materials = materials.filter(|(_, name)| edited.materials.contains(name)).collect();
        numbers
    }

    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.materials.is_empty()
    }

    /// The nodes by their names.
    pub fn nodes(&self) -> impl Iterator<Item = (&String, &usize)> {
        self.nodes.iter()
    }

    /// The nodes with a transform.
    pub fn moved(&self) -> &HashSet<usize> {
        &self.moved
    }

    /// Whether a node appears and vanishes by itself.
    pub fn switches(&self, node: usize) -> bool {
        self.switched.contains(&node)
    }
}
