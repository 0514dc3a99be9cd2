//! Values of the nodes and materials of a model, which replace those of its file.
//!
//! The name of a value has the name of the node or the material in it, which may have points:
//! `object.car.node.Wheel.L.transform.rotate.x`. What follows it is one of a few keys, so the shortest ending that is one counts.

use std::borrow::Cow;

use crate::{
    assets::motion::{EditedParts, Factor, FactorEdit, FactorRange, NodeEdit},
    value::{Span, Spanned},
};

/// The key of an object for nodes of its model.
pub(super) const NODE: &str = "node";
/// The key of an object for materials of its model.
pub(super) const MATERIAL: &str = "material_overrides";

/// The components of a vector, of a colour and of a quaternion.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];
pub(super) const CHANNELS: [&str; 3] = ["r", "g", "b"];
pub(super) const QUATERNION: [&str; 4] = ["qx", "qy", "qz", "qw"];

/// A part of a model that has a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    Node,
    Material,
}

/// The name of a part, and its place in the file.
#[derive(Clone, Debug)]
pub(super) struct PartName {
    pub name: String,
    pub span: Span,
}

/// Values of a model that replace those of its file.
#[derive(Clone, Debug, Default)]
pub struct PartsDesc {
    pub(super) nodes: Vec<(PartName, NodeEdit)>,
    pub(super) materials: Vec<(PartName, Vec<FactorEdit>)>,
    /// The materials of the scene that take the place of some of the model's.
    pub(super) replaced: Vec<(PartName, Spanned<String>)>,
}

impl PartsDesc {
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.materials.is_empty() && self.replaced.is_empty()
    }

    /// The nodes by their names.
    pub fn nodes(&self) -> impl Iterator<Item = (&str, NodeEdit)> {
        self.nodes.iter().map(|(name, edit)| (name.name.as_str(), *edit))
    }

    /// The factors of materials by the names of these.
    pub fn materials(&self) -> impl Iterator<Item = (&str, &[FactorEdit])> {
        self.materials
            .iter()
            .map(|(name, factors)| (name.name.as_str(), factors.as_slice()))
    }

    /// The materials of the scene in place of materials of the model, by the names of these.
    pub fn replaced(&self) -> impl Iterator<Item = (&str, &Spanned<String>)> {
        self.replaced.iter().map(|(name, other)| (name.name.as_str(), other))
    }

    /// All names with their places.
    pub fn names(&self) -> impl Iterator<Item = (Part, &str, Span)> {
        let of = |part, name| {
            let PartName { name, span }: &PartName = name;
            (part, name.as_str(), span.clone())
        };
        let nodes = self.nodes.iter().map(move |(name, _)| of(Part::Node, name));
        let materials = self.materials.iter().map(|(name, _)| name);
        let materials = materials.chain(self.replaced.iter().map(|(name, _)| name));
        nodes.chain(materials.map(move |name| of(Part::Material, name)))
    }

    /// The parts that have values.
    pub fn edited(&self) -> EditedParts {
        let mut edited = EditedParts::default();
        for (PartName { name, .. }, edit) in &self.nodes {
            edited.moved.extend(edit.moves().then(|| name.clone()));
            edited.switched.extend(edit.visible.map(|_| name.clone()));
        }
        let names = self.materials.iter().map(|(name, _)| name.name.clone());
        edited.materials.extend(names);
        edited
    }

    /// Whether the key at `path` of an object belongs to a part of its model and changes the model's pose or its
    /// colours, and not what of it is there.
    pub fn is_of_pose(path: &[String]) -> bool {
        part_of(path).is_some() && path.len() > 2 && path.last().is_none_or(|key| key != "visible")
    }

    /// Adds the part that the key at `path` of an object belongs to, if it belongs to one.
    pub(super) fn add_to(edited: &mut EditedParts, path: &[String]) {
        match path {
            [what, name, .., key] if what == NODE && key == "visible" => edited.switched.insert(name.clone()),
            [what, name, _, ..] if what == NODE => edited.moved.insert(name.clone()),
            [what, name, _, ..] if what == MATERIAL => edited.materials.insert(name.clone()),
            _ => false,
        };
    }
}

/// The part that the key at `path` of an object belongs to, with its name.
pub(super) fn part_of(path: &[String]) -> Option<(Part, &str)> {
    match path {
        [what, name, ..] if what == NODE => Some((Part::Node, name)),
        [what, name, ..] if what == MATERIAL => Some((Part::Material, name)),
        _ => None,
    }
}

/// Whether the key at this path of a scene file belongs to a part of a model.
pub(super) fn is_of_part(path: &[impl AsRef<str>]) -> bool {
    match path {
        [table, _, what, ..] => table.as_ref() == "object" && [NODE, MATERIAL].contains(&what.as_ref()),
        _ => false,
    }
}

/// Returns the path of a key with the name of a node or material of a model as one step.
pub(super) fn joined(path: Vec<Cow<'_, str>>) -> Vec<Cow<'_, str>> {
    let (what, is_key): (_, fn(&[&str]) -> bool) = match &path[..] {
        [table, _, what, _, ..] if table == "object" && what == NODE => (NODE, is_key_of_node),
        [table, _, what, _, ..] if table == "object" && (what == "material" || what == MATERIAL) => {
            (MATERIAL, is_key_of_material)
        }
        _ => return path,
    };
    let steps: Vec<&str> = path[3..].iter().map(AsRef::as_ref).collect();
    let ends = |key: &usize| is_key(&steps[steps.len() - key..]);
    let key = (1..steps.len()).find(ends).unwrap_or_else(|| {
        // A key that is none, after a name of one step or more.
        let component = steps
            .last()
            .is_some_and(|last| AXES.contains(last) || CHANNELS.contains(last));
        let transform = steps.iter().rposition(|step| *step == "transform");
        let from_transform = transform.filter(|at| *at > 0).map(|at| steps.len() - at);
        let last = 1 + usize::from(component);
        from_transform.unwrap_or(last).min(steps.len() - 1)
    });
    let name = steps[..steps.len() - key].join(".");
    let mut joined: Vec<Cow<'_, str>> = path[..2].to_vec();
    joined.extend([Cow::Borrowed(what), Cow::Owned(name)]);
    joined.extend_from_slice(&path[path.len() - key..]);
    joined
}

fn is_key_of_node(path: &[&str]) -> bool {
    match *path {
        ["visible" | "transform"] | ["transform", "translate" | "rotate" | "scale"] => true,
        ["transform", "translate" | "scale", component] => AXES.contains(&component),
        ["transform", "rotate", component] => AXES.contains(&component) || QUATERNION.contains(&component),
        _ => false,
    }
}

fn is_key_of_material(path: &[&str]) -> bool {
    let range = |name: &str| Factor::named(name).map(|factor| factor.range);
    match *path {
        [key] => range(key).is_some(),
        [key, component] => range(key) == Some(FactorRange::Color) && CHANNELS.contains(&component),
        _ => false,
    }
}
