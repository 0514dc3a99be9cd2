//! The nodes of a model that an object shows, and which settings they have.

use std::{collections::HashSet, sync::Arc};

use crate::{assets::model::Model, describe::ObjectDesc, value::matches_wildcards};

/// The nodes of a model that stand together: those of an object without settings of their own, or those of one of its parts.
///
/// A node belongs to the last part that names it or a node above it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Selection {
    patterns: Arc<Patterns>,
    /// The part that is meant, by its index; `None` for what is in no part.
    part: Option<usize>,
}

/// The names of nodes, with wildcards, of an object.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct Patterns {
    /// Those of the nodes that are there with all below them; `None` for all.
    included: Option<Vec<String>>,
    /// Those of each part.
    parts: Vec<Vec<String>>,
}

impl Selection {
    /// The nodes of an object that are in no part.
    pub fn of(object: &ObjectDesc) -> Self {
        let texts =
            |nodes: &Vec<crate::value::Spanned<String>>| nodes.iter().map(|node| node.get_ref().clone()).collect();
        let patterns = Patterns {
            included: object.nodes.as_ref().map(texts),
            parts: object.part.iter().map(|part| texts(&part.nodes)).collect(),
        };
        Self {
            patterns: Arc::new(patterns),
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
        self.patterns.included.is_none() && self.patterns.parts.is_empty()
    }

    /// These nodes of a model.
    pub fn nodes(&self, model: &Model) -> SelectedNodes {
        let memberships = match self.is_whole() {
            true => None,
            false => Some(self.patterns.memberships(model).into()),
        };
        SelectedNodes {
            memberships,
            of_none: self.has_the_rest(),
            part: self.part,
        }
    }

    /// Whether what belongs to no node is meant.
    fn has_the_rest(&self) -> bool {
        self.patterns.included.is_none() && self.part.is_none()
    }
}

impl Patterns {
    /// The settings that each node of a model has.
    fn memberships(&self, model: &Model) -> Vec<Membership> {
        let is_named = |patterns: &[String], name: &str| patterns.iter().any(|p| matches_wildcards(p, name));
        let own = |name: &String| Membership {
            is_included: self.included.as_ref().is_none_or(|patterns| is_named(patterns, name)),
            part: self.parts.iter().rposition(|patterns| is_named(patterns, name)),
        };
        let own: Vec<Membership> = model.names_of_nodes().iter().map(own).collect();
        let mut known: Vec<Option<Membership>> = vec![None; own.len()];
        let mut line = Vec::new();
        for node in 0..own.len() {
            let mut above = Some(node);
            while let Some(node) = above.filter(|node| known[*node].is_none()) {
                line.push(node);
                above = model.nodes[node].parent;
            }
            let mut inherited = above.and_then(|node| known[node]);
            while let Some(node) = line.pop() {
                inherited = Some(inherited.map_or(own[node], |above| own[node].below(above)));
                known[node] = inherited;
            }
        }
        known.into_iter().flatten().collect()
    }
}

/// The settings that a node has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Membership {
    /// Whether it is there.
    is_included: bool,
    /// The part that it belongs to, by its index.
    part: Option<usize>,
}

impl Membership {
    /// The same of a node below another.
    fn below(self, above: Self) -> Self {
        Self {
            is_included: self.is_included || above.is_included,
            part: self.part.max(above.part),
        }
    }
}

/// The nodes of a model that a [`Selection`] means.
#[derive(Clone, Debug, Default)]
pub(super) struct SelectedNodes {
    /// The settings of each node, which all parts of an object share; `None` if all nodes are meant.
    memberships: Option<Arc<[Membership]>>,
    /// Whether what belongs to no node is meant.
    of_none: bool,
    part: Option<usize>,
}

impl SelectedNodes {
    /// Those of a part of the object of which these are, in the same model.
    pub fn of(&self, selection: &Selection) -> Self {
        Self {
            of_none: selection.has_the_rest(),
            part: selection.part,
            ..self.clone()
        }
    }

    /// Whether no node is meant.
    pub fn is_empty(&self) -> bool {
        let is_meant = |one: &Membership| one.is_included && one.part == self.part;
        let memberships = self.memberships.as_ref();
        !self.of_none && memberships.is_some_and(|all| !all.iter().any(is_meant))
    }

    /// Whether `node` is meant, or what belongs to no node.
    fn has(&self, node: Option<usize>) -> bool {
        let Some(memberships) = &self.memberships else {
            return true;
        };
        node.map_or(self.of_none, |node| {
            memberships[node].is_included && memberships[node].part == self.part
        })
    }

    /// The parts of a model, by their indices, that are none of these.
    pub fn left_out(&self, model: &Model) -> HashSet<usize> {
        if self.memberships.is_none() {
            return HashSet::new();
        }
        let parts = model.instances.iter().enumerate();
        let left_out = parts.filter(|(_, part)| !self.has(part.node));
        left_out.map(|(i, _)| i).collect()
    }

    /// Whether a light of a model is one of these.
    pub fn has_light(&self, model: &Model, light: usize) -> bool {
        self.has(model.light_nodes.get(light).copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::model::ModelNode;

    /// A model of nodes with these names and parents.
    fn model(nodes: &[(&str, Option<usize>)]) -> Model {
        let node = |(name, parent): &(&str, Option<usize>)| ModelNode {
            name: (*name).to_owned(),
            parent: *parent,
        };
        Model {
            nodes: nodes.iter().map(node).collect(),
            ..Model::default()
        }
    }

    fn selection(included: Option<&[&str]>, parts: &[&[&str]]) -> Selection {
        let texts = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let patterns = Patterns {
            included: included.map(texts),
            parts: parts.iter().map(|names| texts(names)).collect(),
        };
        Selection {
            patterns: Arc::new(patterns),
            part: None,
        }
    }

    fn shown(nodes: &SelectedNodes, count: usize) -> Vec<bool> {
        (0..count).map(|node| nodes.has(Some(node))).collect()
    }

    #[test]
    fn nodes_inherit_from_those_above_them_in_whichever_order_they_stand() {
        // A hub below a wheel below a body, children first, and a mast.
        let model = model(&[("hub", Some(1)), ("wheel", Some(2)), ("body", None), ("mast", None)]);
        let object = selection(Some(&["body"]), &[&["wheel"], &["mast"]]);
        let whole = object.nodes(&model);
        assert_eq!(shown(&whole, 4), [false, false, true, false]);
        assert_eq!(shown(&whole.of(&object.of_part(0)), 4), [true, true, false, false]);
        assert_eq!(shown(&whole.of(&object.of_part(1)), 4), [false; 4]);
        assert!(!whole.has(None));
        let all = Selection::default().nodes(&model);
        assert_eq!((shown(&all, 4), all.has(None)), (vec![true; 4], true));
    }

    #[test]
    fn a_hundred_thousand_nodes_in_a_line_are_found_at_once() {
        let mut nodes = vec![("top", None)];
        nodes.extend((0..100_000).map(|above| ("", Some(above))));
        let nodes = selection(Some(&["top"]), &[]).nodes(&model(&nodes));
        assert!(shown(&nodes, 100_001).into_iter().all(|is_shown| is_shown));
    }
}
