//! The nodes of a model that an object shows, and which settings they have.

use std::collections::HashSet;

use crate::{assets::model::Model, describe::ObjectDesc, value::matches_wildcards};

/// The nodes of a model that stand together: those of an object without settings of their own, or those of one of its parts.
///
/// A node belongs to the last part that names it or a node above it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Selection {
    /// The patterns of the nodes that are there with all below them; `None` for all.
    included: Option<Vec<String>>,
    /// The patterns of each part.
    parts: Vec<Vec<String>>,
    /// The part that is meant, by its index; `None` for what is in no part.
    part: Option<usize>,
}

impl Selection {
    /// The nodes of an object that are in no part.
    pub fn of(object: &ObjectDesc) -> Self {
        let texts =
            |nodes: &Vec<crate::value::Spanned<String>>| nodes.iter().map(|node| node.get_ref().clone()).collect();
        Self {
            included: object.nodes.as_ref().map(texts),
            parts: object.part.iter().map(|part| texts(&part.nodes)).collect(),
            part: None,
        }
    }

    /// The nodes of a part, by its index.
    pub fn of_part(&self, part: usize) -> Self {
        Self {
            part: Some(part),
            ..self.clone()
        }
    }

    /// Whether these are all nodes.
    pub fn is_whole(&self) -> bool {
        self.included.is_none() && self.parts.is_empty()
    }

    /// Whether each node of a model is one of these, and whether what belongs to no node is.
    fn nodes(&self, model: &Model) -> (Vec<bool>, bool) {
        let is_named = |patterns: &[String], name: &str| patterns.iter().any(|p| matches_wildcards(p, name));
        let names = model.names_of_nodes();
        let own = |name: &String| {
            let part = self.parts.iter().rposition(|patterns| is_named(patterns, name));
            let included = self.included.as_ref().is_none_or(|patterns| is_named(patterns, name));
            (included, part)
        };
        let own: Vec<(bool, Option<usize>)> = names.iter().map(own).collect();
        let chosen = |node: usize| {
            let line = std::iter::successors(Some(node), |node| model.nodes[*node].parent);
            let line = line.map(|node| own[node]);
            // Parents of broken files may be in a circle.
            let all = line.take(own.len()).reduce(|(a, b), (c, d)| (a || c, b.max(d)));
            all.is_some_and(|(included, part)| included && part == self.part)
        };
        let of_none = self.included.is_none() && self.part.is_none();
        ((0..own.len()).map(chosen).collect(), of_none)
    }

    /// The parts of a model, by their indices, that are none of these.
    pub fn left_out(&self, model: &Model) -> HashSet<usize> {
        if self.is_whole() {
            return HashSet::new();
        }
        let (nodes, of_none) = self.nodes(model);
        let is_out = |node: Option<usize>| !node.map_or(of_none, |node| nodes[node]);
        let parts = model.instances.iter().enumerate();
        parts.filter(|(_, part)| is_out(part.node)).map(|(i, _)| i).collect()
    }

    /// Whether each light of a model is one of these.
    pub fn lights(&self, model: &Model) -> Vec<bool> {
        if self.is_whole() {
            return vec![true; model.lights.len()];
        }
        let (nodes, of_none) = self.nodes(model);
        let has = |light: usize| model.light_nodes.get(light).map_or(of_none, |node| nodes[*node]);
        (0..model.lights.len()).map(has).collect()
    }
}
