//! The tables of nodes and materials of a model in an object.

use std::borrow::Cow;

use toml::de::{DeTable, DeValue};

use super::{
    parts::{AXES, CHANNELS, MATERIAL, NODE, PartName, PartsDesc, QUATERNION},
    read::Reader,
    rotation::QuaternionDesc,
};
use crate::{
    assets::motion::{Factor, FactorEdit, FactorRange, NewNumbers, NewRotation, NodeEdit},
    shape::mesh::Precise,
    value::{Coordinate, Problem, Spanned, UnknownName},
};

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
                if value.get_ref().is_str() {
                    let other = self.entity(value);
                    parts.replaced.extend(other.map(|other| (name(key), other)));
                    continue;
                }
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
                            "scale" => edit.scale = self.scale(value),
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

    /// The scale of a node, which must not flatten what is below it.
    fn scale(&mut self, value: Value<'_>) -> NewNumbers {
        let span = value.span();
        let numbers = self.coordinates(value);
        if numbers.contains(&Some(0.0)) && !self.may_flatten {
            let problem = Problem::at(span, "the scale of a node cannot be 0");
            self.problems.push(problem.with_help("`visible = false` hides it"));
        }
        numbers
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
