//! The schema of a type that can be deserialized, found by deserializing it: a [`Probe`] notes what the type asks for at one place, and
//! offers values there to learn which it takes.

use std::{
    cell::{Cell, RefCell},
    fmt,
};

use serde::{
    Deserialize,
    de::{
        self, DeserializeSeed, Deserializer, EnumAccess, MapAccess, SeqAccess, VariantAccess, Visitor,
        value::{BorrowedStrDeserializer, StrDeserializer},
    },
};
use serde_json::{Map, Value, json};

/// Tables are nested no deeper.
const DEEPEST: usize = 10;
/// The longest list of a fixed length.
const LONGEST: usize = 16;

/// The schema of `T`.
pub fn schema_of<T: for<'de> Deserialize<'de>>() -> Value {
    at(&|probe| T::deserialize(probe).map(drop), &mut Vec::new())
}

/// A key, a variant, or `None` for the elements of a list.
type Step = Option<String>;
type Read<'a> = &'a dyn Fn(Probe<'_>) -> Result<(), Fault>;

/// The kind of value that a type requests from the deserializer.
#[derive(Clone, Debug)]
enum Asked {
    Anything,
    Type(&'static str),
    List,
    Fields(&'static [&'static str]),
    Variants(&'static [&'static str]),
}

/// A value that is offered at the place.
#[derive(Clone, Copy, Debug)]
enum Offer {
    Nothing,
    Bool,
    Integer,
    Number,
    Text,
    /// A list of so many numbers.
    Numbers(usize),
    /// A list of one text.
    Texts,
    /// A table with an unknown key.
    Table,
}

/// Why a type does not take a value.
#[derive(Debug)]
enum Fault {
    /// Values of this type are rejected.
    Type,
    /// The names that are known.
    Names(&'static [&'static str]),
    Other(String),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

impl std::error::Error for Fault {}

impl de::Error for Fault {
    fn custom<T: fmt::Display>(message: T) -> Self {
        let message = message.to_string();
        match message.contains("did not match any variant") {
            true => Self::Type,
            false => Self::Other(message),
        }
    }

    fn invalid_type(_: de::Unexpected<'_>, _: &dyn de::Expected) -> Self {
        Self::Type
    }

    fn unknown_variant(_: &str, expected: &'static [&'static str]) -> Self {
        Self::Names(expected)
    }

    fn unknown_field(_: &str, expected: &'static [&'static str]) -> Self {
        Self::Names(expected)
    }
}

/// The schema at a place.
fn at(read: Read<'_>, place: &mut Vec<Step>) -> Value {
    assert!(place.len() < DEEPEST, "{place:?}");
    let (asked, is_taken) = (RefCell::new(None), Cell::new(false));
    let offer = |offer: Offer| {
        is_taken.set(false);
        read(Probe {
            place,
            offer,
            asked: &asked,
            is_taken: &is_taken,
        })
    };
    let lengths = || {
        let is_taken = |count: &usize| {
            let _ = offer(Offer::Numbers(*count));
            is_taken.get()
        };
        let taken: Vec<usize> = (0..=LONGEST).filter(is_taken).collect();
        let (first, last) = (taken.first()?, taken.last()?);
        (1..LONGEST).contains(last).then_some([*first, *last])
    };
    let _ = offer(Offer::Nothing);
    let Some(first) = asked.borrow().clone() else {
        panic!("nothing is asked for at {place:?}");
    };
    match first {
        Asked::Type("string") => text(offer(Offer::Text)),
        Asked::Type(name) => json!({ "type": name }),
        Asked::Fields(fields) => table(fields, read, place),
        Asked::Variants(variants) => choice(variants, read, place),
        Asked::List => {
            let lengths = lengths();
            list(lengths, read, place)
        }
        Asked::Anything => {
            let takes = |of: Offer| !matches!(offer(of), Err(Fault::Type));
            let mut choices = Vec::new();
            if takes(Offer::Bool) {
                choices.push(json!({ "type": "boolean" }));
            }
            match (takes(Offer::Number), takes(Offer::Integer)) {
                (true, _) => choices.push(json!({ "type": "number" })),
                (false, true) => choices.push(json!({ "type": "integer" })),
                (false, false) => {}
            }
            if takes(Offer::Text) {
                choices.push(text(offer(Offer::Text)));
            }
            let (is_list, lengths) = (takes(Offer::Numbers(1)) || takes(Offer::Texts), lengths());
            let of_table = offer(Offer::Table);
            if is_list {
                choices.push(list(lengths, read, place));
            }
            match of_table {
                Err(Fault::Type) => {}
                Err(Fault::Names(names)) => choices.push(table(names, read, place)),
                _ => choices.push(json!({ "type": "object" })),
            }
            match &mut choices[..] {
                [only] => only.take(),
                _ => json!({ "anyOf": choices }),
            }
        }
    }
}

/// The schema of a text that was taken or refused in this way.
fn text(result: Result<(), Fault>) -> Value {
    match result {
        Err(Fault::Names(names)) => json!({ "enum": names }),
        Err(Fault::Other(message)) if message.contains("expected one of `") => {
            let names = message.split("expected one of ").nth(1).unwrap_or_default();
            let names: Vec<&str> = names.split('`').skip(1).step_by(2).collect();
            json!({ "enum": names })
        }
        _ => json!({ "type": "string" }),
    }
}

fn list(lengths: Option<[usize; 2]>, read: Read<'_>, place: &mut Vec<Step>) -> Value {
    let mut list = json!({ "type": "array", "items": inside(None, read, place) });
    if let Some([least, most]) = lengths {
        list["minItems"] = json!(least);
        list["maxItems"] = json!(most);
    }
    list
}

/// The schema of a table with these keys.
fn table(keys: &[&str], read: Read<'_>, place: &mut Vec<Step>) -> Value {
    let properties = keys
        .iter()
        .map(|key| ((*key).to_owned(), inside(Some(key), read, place)));
    let properties: Map<String, Value> = properties.collect();
    json!({ "type": "object", "additionalProperties": false, "properties": properties })
}

/// The schema of an enum: names alone, tables of one key, or both.
fn choice(variants: &[&str], read: Read<'_>, place: &mut Vec<Step>) -> Value {
    let mut names = Vec::new();
    let mut tables = Map::new();
    for name in variants {
        place.push(Some((*name).to_owned()));
        let asked = RefCell::new(None);
        let _ = read(Probe {
            place,
            offer: Offer::Nothing,
            asked: &asked,
            is_taken: &Cell::new(false),
        });
        let is_unit = asked.borrow().is_none();
        match is_unit {
            true => names.push(*name),
            false => drop(tables.insert((*name).to_owned(), at(read, place))),
        }
        place.pop();
    }
    let tables = json!({ "type": "object", "additionalProperties": false, "properties": tables });
    match (names.is_empty(), names.len() == variants.len()) {
        (true, _) => tables,
        (_, true) => json!({ "enum": names }),
        _ => json!({ "anyOf": [tables, { "enum": names }] }),
    }
}

fn inside(step: Option<&str>, read: Read<'_>, place: &mut Vec<Step>) -> Value {
    place.push(step.map(str::to_owned));
    let schema = at(read, place);
    place.pop();
    schema
}

/// Offers a value at a place.
#[derive(Clone, Copy)]
struct Probe<'a> {
    place: &'a [Step],
    offer: Offer,
    asked: &'a RefCell<Option<Asked>>,
    /// Whether the value was taken that was offered last.
    is_taken: &'a Cell<bool>,
}

impl Probe<'_> {
    fn within(self) -> Self {
        Self {
            place: &self.place[1..],
            ..self
        }
    }

    fn answer<'de, V: Visitor<'de>>(self, asked: Asked, visitor: V) -> Result<V::Value, Fault> {
        match self.place.first() {
            Some(Some(key)) => return visitor.visit_map(Entry(Some((key, self.within())))),
            Some(None) => return visitor.visit_seq(Elements(self.within(), 1)),
            None => {}
        }
        self.asked.borrow_mut().get_or_insert(asked);
        let inside = |offer| Self { offer, ..self };
        let taken = match self.offer {
            Offer::Nothing => Err(Fault::Other("nothing is offered".to_owned())),
            Offer::Bool => visitor.visit_bool(true),
            Offer::Integer => visitor.visit_i64(1),
            Offer::Number => visitor.visit_f64(0.5),
            Offer::Text => visitor.visit_str("?"),
            Offer::Numbers(count) => visitor.visit_seq(Elements(inside(Offer::Number), count)),
            Offer::Texts => visitor.visit_seq(Elements(inside(Offer::Text), 1)),
            Offer::Table => visitor.visit_map(Entry(Some(("?", inside(Offer::Number))))),
        };
        self.is_taken.set(taken.is_ok());
        taken
    }
}

macro_rules! types {
    ($($method:ident: $name:literal),* $(,)?) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
            self.answer(Asked::Type($name), visitor)
        })*
    };
}

impl<'de> Deserializer<'de> for Probe<'_> {
    type Error = Fault;

    types!(
        deserialize_bool: "boolean", deserialize_i8: "integer", deserialize_i16: "integer", deserialize_i32: "integer",
        deserialize_i64: "integer", deserialize_u8: "integer", deserialize_u16: "integer", deserialize_u32: "integer",
        deserialize_u64: "integer", deserialize_f32: "number", deserialize_f64: "number", deserialize_char: "string",
        deserialize_str: "string", deserialize_string: "string", deserialize_identifier: "string",
    );

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.answer(Asked::Anything, visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.answer(Asked::List, visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Fault> {
        self.answer(Asked::List, visitor)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: usize,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        self.answer(Asked::List, visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match serde_spanned::de::is_spanned(name) {
            true => visitor.visit_map(SpannedEntries(fields, self)),
            false => self.answer(Asked::Fields(fields), visitor),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.place.first() {
            Some(Some(_)) => visitor.visit_enum(self),
            _ => {
                self.asked.borrow_mut().get_or_insert(Asked::Variants(variants));
                Err(Fault::Other("an enum".to_owned()))
            }
        }
    }

    serde::forward_to_deserialize_any! { bytes byte_buf unit unit_struct map ignored_any }
}

impl<'de, 'a> EnumAccess<'de> for Probe<'a> {
    type Error = Fault;
    type Variant = Self;

    fn variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<(T::Value, Self), Fault> {
        let name = self.place[0].as_deref().unwrap_or_default();
        Ok((seed.deserialize(StrDeserializer::new(name))?, self.within()))
    }
}

impl<'de> VariantAccess<'de> for Probe<'_> {
    type Error = Fault;

    fn unit_variant(self) -> Result<(), Fault> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Fault> {
        seed.deserialize(self)
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Fault> {
        self.answer(Asked::List, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(self, fields: &'static [&'static str], visitor: V) -> Result<V::Value, Fault> {
        self.answer(Asked::Fields(fields), visitor)
    }
}

/// A table of one key.
struct Entry<'a, 'k>(Option<(&'k str, Probe<'a>)>);

impl<'de> MapAccess<'de> for Entry<'_, '_> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        let key = self
            .0
            .as_ref()
            .map(|(key, _)| seed.deserialize(StrDeserializer::new(key)));
        key.transpose()
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        let (_, value) = self.0.take().expect("a value follows its key");
        seed.deserialize(value)
    }
}

/// A value with a place in a file.
struct SpannedEntries<'a>(&'static [&'static str], Probe<'a>);

impl<'de> MapAccess<'de> for SpannedEntries<'_> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        let key = self.0.first();
        key.map(|key| seed.deserialize(BorrowedStrDeserializer::new(key)))
            .transpose()
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        let (key, rest) = self.0.split_first().expect("a value follows its key");
        self.0 = rest;
        match key.contains("value") {
            true => seed.deserialize(self.1),
            false => seed.deserialize(de::value::UsizeDeserializer::new(0)),
        }
    }
}

/// A list of the same element, so many times.
struct Elements<'a>(Probe<'a>, usize);

impl<'de> SeqAccess<'de> for Elements<'_> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Fault> {
        let Some(left) = self.1.checked_sub(1) else {
            return Ok(None);
        };
        self.1 = left;
        seed.deserialize(self.0).map(Some)
    }
}
