//! Values of a scene file as serde reads them.
//!
//! A deserializer of its own, since that of the TOML crate reads a list in place of a table: the elements as the keys of a struct
//! in the order of its fields, which is no order that a user knows.

use std::fmt;

use serde::{
    de::{
        self, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, MapAccess, SeqAccess, Unexpected,
        VariantAccess, Visitor,
        value::{CowStrDeserializer, StrDeserializer},
    },
    forward_to_deserialize_any,
};
use serde_spanned::de::{SpannedDeserializer, is_spanned};
use toml::de::{DeArray, DeString, DeTable, DeValue};

use super::{Overrides, foreign, wording::in_words_of_the_file};
use crate::{
    integrator::{IntegratorDesc, replacing_pass},
    value::{Problem, Span, Spanned, UnknownName, is_override},
};

/// Why a value could not be read, and the innermost value that is wrong.
#[derive(Debug)]
pub(super) struct ReadError {
    pub message: String,
    pub span: Option<Span>,
}

impl ReadError {
    /// The same at `span`, unless a part of that is wrong.
    pub fn within(self, span: Span) -> Self {
        Self {
            span: self.span.or(Some(span)),
            ..self
        }
    }

    /// Returns the problem, with the usual wording for unknown names.
    pub fn problem(self, overrides: &Overrides) -> Problem {
        let Self { message, span } = self;
        let message = message.trim_end();
        let mut quoted = message.split('`').skip(1).step_by(2);
        if let Some((what, _)) = message.strip_prefix("unknown ").and_then(|rest| rest.split_once(" `")) {
            let span = span.unwrap_or(0..0);
            let what = match what {
                "field" => "key",
                "variant" => overrides
                    .named(&span, quoted.clone().next().unwrap_or_default())
                    .unwrap_or("kind"),
                named => named,
            };
            let word = quoted.next().unwrap_or_default().to_owned();
            let known: Vec<&str> = quoted.collect();
            let is_override = is_override(&span);
            let unknown = UnknownName::new(what, &word, known.iter().copied());
            let mut problem = unknown.at(span);
            problem.help = foreign::help(&word, &known).or(problem.help);
            return match replacing_pass(&word).filter(|_| known == IntegratorDesc::NAMES) {
                Some(pass) if is_override => {
                    problem.with_help(format!("it is a pass and no integrator: use --show {pass}"))
                }
                Some(pass) => problem.with_help(format!(
                    "it is a pass and no integrator: `[output] show = \"{pass}\"` or `aovs = [\"{pass}\"]`"
                )),
                None => problem,
            };
        }
        Problem {
            span,
            message: in_words_of_the_file(message),
            help: None,
        }
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for ReadError {}

impl de::Error for ReadError {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self {
            message: message.to_string(),
            span: None,
        }
    }
}

fn too_large(number: &str) -> ReadError {
    de::Error::custom(format_args!("{number} is too large"))
}

/// A value that is read.
pub(super) struct FileValue<'i>(pub Spanned<DeValue<'i>>);

impl<'de> IntoDeserializer<'de, ReadError> for FileValue<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> FileValue<'de> {
    /// Visits the value. An integer goes to the smallest type that holds it.
    fn visit<V: Visitor<'de>>(value: DeValue<'de>, visitor: V) -> Result<V::Value, ReadError> {
        match value {
            DeValue::String(DeString::Borrowed(v)) => visitor.visit_borrowed_str(v),
            DeValue::String(DeString::Owned(v)) => visitor.visit_string(v),
            DeValue::Integer(v) => {
                let digits = v.as_str();
                match (
                    i64::from_str_radix(digits, v.radix()),
                    u64::from_str_radix(digits, v.radix()),
                ) {
                    (Ok(v), _) => visitor.visit_i64(v),
                    (Err(_), Ok(v)) => visitor.visit_u64(v),
                    (Err(_), Err(_)) => Err(too_large(digits)),
                }
            }
            DeValue::Float(v) => match v.as_str().parse::<f64>() {
                Ok(number) if number.is_finite() || v.as_str().contains(['i', 'n']) => visitor.visit_f64(number),
                _ => Err(too_large(v.as_str())),
            },
            DeValue::Boolean(v) => visitor.visit_bool(v),
            DeValue::Datetime(_) => Err(de::Error::invalid_type(Unexpected::Other("a date"), &visitor)),
            DeValue::Array(list) => visitor.visit_seq(Elements(list.into_iter())),
            DeValue::Table(table) => visitor.visit_map(Keys::of(table)),
        }
    }
}

impl<'de> Deserializer<'de> for FileValue<'de> {
    type Error = ReadError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadError> {
        let span = self.0.span();
        Self::visit(self.0.into_inner(), visitor).map_err(|e| e.within(span))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadError> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        let span = self.0.span();
        visitor.visit_newtype_struct(self).map_err(|e| e.within(span))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        let span = self.0.span();
        if is_spanned(name) {
            return visitor.visit_map(SpannedDeserializer::new(self, span));
        }
        if self.0.get_ref().is_array() {
            let error: ReadError = de::Error::invalid_type(Unexpected::Seq, &visitor);
            return Err(error.within(span));
        }
        self.deserialize_any(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        let span = self.0.span();
        let read = match self.0.into_inner() {
            DeValue::String(name) => visitor.visit_enum(StrDeserializer::new(&name)),
            DeValue::Table(table) if table.len() == 1 => visitor.visit_enum(Keys::of(table)),
            DeValue::Table(table) => {
                let message = format_args!("expected a table with one key, found {}", table.len());
                Err(de::Error::custom(message))
            }
            other => {
                let message = format_args!("expected a name or a table, found {}", other.type_str());
                Err(de::Error::custom(message))
            }
        };
        read.map_err(|e: ReadError| e.within(span))
    }

    forward_to_deserialize_any! {
        bool u8 u16 u32 u64 u128 i8 i16 i32 i64 i128 f32 f64 char str string seq bytes byte_buf map unit ignored_any unit_struct
        tuple_struct tuple identifier
    }
}

/// The elements of a list.
struct Elements<'i>(<DeArray<'i> as IntoIterator>::IntoIter);

impl<'de> SeqAccess<'de> for Elements<'de> {
    type Error = ReadError;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, ReadError> {
        let next = self.0.next().map(|value| seed.deserialize(FileValue(value)));
        next.transpose()
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

/// The keys of a table.
struct Keys<'i> {
    rest: <DeTable<'i> as IntoIterator>::IntoIter,
    /// The value of the last key.
    value: Option<Spanned<DeValue<'i>>>,
}

impl<'de> Keys<'de> {
    fn of(table: DeTable<'de>) -> Self {
        Self {
            rest: table.into_iter(),
            value: None,
        }
    }

    fn take_value(&mut self) -> FileValue<'de> {
        FileValue(self.value.take().expect("a key is read before its value"))
    }
}

impl<'de> MapAccess<'de> for Keys<'de> {
    type Error = ReadError;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, ReadError> {
        let Some((key, value)) = self.rest.next() else {
            return Ok(None);
        };
        self.value = Some(value);
        let span = key.span();
        let name: CowStrDeserializer<'_, ReadError> = key.into_inner().into_deserializer();
        seed.deserialize(name).map(Some).map_err(|e| e.within(span))
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, ReadError> {
        let value = self.take_value();
        let span = value.0.span();
        seed.deserialize(value).map_err(|e| e.within(span))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

impl<'de> EnumAccess<'de> for Keys<'de> {
    type Error = ReadError;
    type Variant = FileValue<'de>;

    fn variant_seed<V: DeserializeSeed<'de>>(mut self, seed: V) -> Result<(V::Value, FileValue<'de>), ReadError> {
        let name = self.next_key_seed(seed)?;
        let name = name.ok_or_else(|| de::Error::custom("expected a table with one key, found 0"))?;
        Ok((name, self.take_value()))
    }
}

impl<'de> VariantAccess<'de> for FileValue<'de> {
    type Error = ReadError;

    fn unit_variant(self) -> Result<(), ReadError> {
        let is_empty = |value: &DeValue<'_>| value.as_table().is_some_and(DeTable::is_empty);
        match is_empty(self.0.get_ref()) {
            true => Ok(()),
            false => Err(<ReadError as de::Error>::custom("expected an empty table").within(self.0.span())),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, ReadError> {
        seed.deserialize(self)
    }

    fn tuple_variant<V: Visitor<'de>>(self, _len: usize, visitor: V) -> Result<V::Value, ReadError> {
        self.deserialize_any(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        self.deserialize_struct("", fields, visitor)
    }
}
