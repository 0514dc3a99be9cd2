//! Values of the nodes and materials of a model, which replace those of its file.
//!
//! The name of a value has the name of the node or the material in it, which may have points:
//! `object.car.node.Wheel.L.transform.rotate.x`. What follows it is one of a few keys, so the shortest ending that is one counts.

use std::borrow::Cow;

use toml::de::{DeTable, DeValue};

use super::{read::Reader, rotation::QuaternionDesc};
use crate::{
    assets::motion::{EditedParts, Factor, FactorEdit, FactorRange, NewNumbers, NewRotation, NodeEdit},
    shape::mesh::Precise,
    value::{Coordinate, Problem, Span, Spanned, UnknownName},
};

/// The key of an object for nodes of its model.
pub(super) const NODE: &str = "node";
/// The key of an object for materials of its model.
pub(super) const MATERIAL: &str = "material_overrides";

/// The components of a vector, of a colour and of a quaternion.
const AXES: [&str; 3] = ["x", "y", "z"];
const CHANNELS: [&str; 3] = ["r", "g", "b"];
pub(super) const QUATERNION: [&str; 4] = ["qx", "qy", "qz", "qw"];

/// A part of a model that has a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    Node,
    Material,
}

/// The name of a part, and its place in the file.
#[derive(Clone, Debug)]
struct PartName {
    name: String,
    span: Span,
}

/// Values of a model that replace those of its file.
#[derive(Clone, Debug, Default)]
pub struct PartsDesc {
    nodes: Vec<(PartName, NodeEdit)>,
    materials: Vec<(PartName, Vec<FactorEdit>)>,
}

impl PartsDesc {
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.materials.is_empty()
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

    /// All names with their places.
    pub fn names(&self) -> impl Iterator<Item = (Part, &str, Span)> {
        let of = |part, name| {
            let PartName { name, span }: &PartName = name;
            (part, name.as_str(), span.clone())
        };
        let nodes = self.nodes.iter().map(move |(name, _)| of(Part::Node, name));
        nodes.chain(self.materials.iter().map(move |(name, _)| of(Part::Material, name)))
    }

    /// The parts that have values.
    pub fn edited(&self) -> EditedParts {
        let mut edited = EditedParts::default();
        for (PartName { name, .. }, edit) in &self.nodes {
            edited.moved.extend(edit.moves().then(|| name.clone()));
            edited.switched.extend(edit.visible.map(|_| name.clone()));
        }
        edited.materials = self.materials.iter().map(|(name, _)| name.name.clone()).collect();
        edited
    }

    /// Whether the key at `path` of an object belongs to a part of its model and changes the model's pose or its colours, and not what of
    /// it is there.
    pub fn is_of_pose(path: &[String]) -> bool {
        part_of(path).is_some() && path.last().is_none_or(|key| key != "visible")
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

type Value<'i> = Spanned<DeValue<'i>>;

impl Reader<'_> {
    /// Takes the values of nodes and materials out of the table of an object.
    pub fn parts(&mut self, object: &mut Value<'_>) -> PartsDesc {
        let mut parts = PartsDesc::default();
        let DeValue::Table(table) = object.get_mut() else {
            return parts;
        };
        if let Some(nodes) = table.remove(NODE).and_then(|nodes| self.table(nodes, NODE)) {
            for (key, value) in nodes {
                let Some(keys) = self.table(value, key.get_ref()) else {
                    continue;
                };
                let edit = self.node(keys);
                parts.nodes.push((name(key), edit));
            }
        }
        let materials = table.remove(MATERIAL);
        if let Some(materials) = materials.and_then(|materials| self.table(materials, MATERIAL)) {
            for (key, value) in materials {
                let Some(keys) = self.table(value, key.get_ref()) else {
                    continue;
                };
                let factors = keys.into_iter().filter_map(|(key, value)| self.factor(&key, value));
                let factors = factors.collect();
                parts.materials.push((name(key), factors));
            }
        }
        parts
    }

    /// The table that `value` is.
    fn table<'i>(&mut self, value: Value<'i>, key: &str) -> Option<DeTable<'i>> {
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(table) => Some(table),
            other => {
                let message = format!("`{key}` is a table and cannot be of type {}", other.type_str());
                self.problems.push(Problem::at(span, message));
                None
            }
        }
    }

    fn unknown(&mut self, key: &Spanned<Cow<'_, str>>, known: &[&str]) {
        let unknown = UnknownName::new("key", key.get_ref(), known.iter().copied());
        self.problems.push(unknown.at(key.span()));
    }

    fn node(&mut self, keys: DeTable<'_>) -> NodeEdit {
        let mut edit = NodeEdit::default();
        for (key, value) in keys {
            match key.get_ref().as_ref() {
                "visible" => edit.visible = self.entity(value),
                "transform" => {
                    for (key, value) in self.table(value, "transform").into_iter().flatten() {
                        match key.get_ref().as_ref() {
                            "translate" => edit.translation = self.coordinates(value),
                            "scale" => edit.scale = self.coordinates(value),
                            "rotate" => edit.rotation = self.rotation(value),
                            _ => self.unknown(&key, &["translate", "rotate", "scale"]),
                        }
                    }
                }
                _ => self.unknown(&key, &["transform", "visible"]),
            }
        }
        edit
    }

    /// Numbers of a transform.
    fn coordinates(&mut self, value: Value<'_>) -> NewNumbers {
        let numbers = self.numbers(value, AXES, FactorRange::Any);
        numbers.map(|number| number.map(|v| Coordinate::new(v).0))
    }

    fn rotation(&mut self, value: Value<'_>) -> Option<NewRotation> {
        let is_quaternion = |key: &Spanned<Cow<'_, str>>| QUATERNION.contains(&key.get_ref().as_ref());
        match value.get_ref() {
            DeValue::Table(keys) if keys.keys().any(is_quaternion) => {
                let rotation = self.entity::<QuaternionDesc>(value)?;
                Some(NewRotation::Quaternion(rotation.0))
            }
            _ => Some(NewRotation::Angles(self.coordinates(value))),
        }
    }

    fn factor(&mut self, key: &Spanned<Cow<'_, str>>, value: Value<'_>) -> Option<FactorEdit> {
        let Some(factor) = Factor::named(key.get_ref()) else {
            let names: Vec<&str> = Factor::names().collect();
            self.unknown(key, &names);
            return None;
        };
        let numbers = match factor.range {
            FactorRange::Color => self.numbers(value, CHANNELS, factor.range),
            FactorRange::Angle => [self.number(value, factor.range).map(f64::to_radians), None, None],
            range => [self.number(value, range), None, None],
        };
        Some(FactorEdit {
            factor,
            numbers: numbers.map(|number| number.map(|v| v as f32)),
        })
    }

    /// Three numbers: one for all of them, a list, or a table with some of them.
    fn numbers(&mut self, value: Value<'_>, names: [&str; 3], range: FactorRange) -> NewNumbers {
        let span = value.span();
        match value.into_inner() {
            DeValue::Array(list) if list.len() == 3 => {
                let mut list = list.into_iter();
                std::array::from_fn(|_| self.number(list.next()?, range))
            }
            DeValue::Array(list) => {
                let message = format!("expected three numbers, found {}", list.len());
                self.problems.push(Problem::at(span, message));
                [None; 3]
            }
            DeValue::Table(keys) => {
                let mut numbers = [None; 3];
                for (key, value) in keys {
                    match names.iter().position(|name| *name == key.get_ref()) {
                        Some(at) => numbers[at] = self.number(value, range),
                        None => self.unknown(&key, &names),
                    }
                }
                numbers
            }
            one => [self.number(Spanned::new(span, one), range); 3],
        }
    }

    fn number(&mut self, value: Value<'_>, range: FactorRange) -> Option<f64> {
        let span = value.span();
        let v = self.entity::<Precise>(value)?.0;
        match range.expected(v) {
            None => Some(v),
            Some(expected) => {
                let message = format!("expected {expected}, found {v}");
                self.problems.push(Problem::at(span, message));
                None
            }
        }
    }
}

fn name(key: Spanned<Cow<'_, str>>) -> PartName {
    PartName {
        span: key.span(),
        name: key.into_inner().into_owned(),
    }
}
