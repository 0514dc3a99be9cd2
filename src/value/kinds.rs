//! Kinds by name: an externally tagged kind, whose name alone stands for the kind with its
//! defaults.

use std::{fmt, marker::PhantomData};

use serde::{Deserialize, Deserializer, de};

/// Reads an externally tagged kind, where a bare `"NAME"` is short for `NAME = {}`.
///
/// For `#[serde(deserialize_with = "value::kind_or_name")]`.
pub fn kind_or_name<'de, D: Deserializer<'de>, T: Deserialize<'de>>(d: D) -> Result<T, D::Error> {
    struct KindOrNameVisitor<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> de::Visitor<'de> for KindOrNameVisitor<T> {
        type Value = T;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a name or a table NAME = { .. }")
        }
        fn visit_str<E: de::Error>(self, name: &str) -> Result<T, E> {
            let empty = de::value::MapDeserializer::<_, E>::new(std::iter::empty::<(&str, ())>());
            T::deserialize(EmptyVariant { name, empty })
        }
        fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
            T::deserialize(de::value::MapAccessDeserializer::new(map))
        }
    }
    d.deserialize_any(KindOrNameVisitor(PhantomData))
}

/// Reads a name, which may look like a number.
pub fn name<'de, D: Deserializer<'de>>(d: D) -> Result<String, D::Error> {
    struct NameVisitor;
    impl de::Visitor<'_> for NameVisitor {
        type Value = String;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a name")
        }
        fn visit_str<E: de::Error>(self, name: &str) -> Result<String, E> {
            Ok(name.to_owned())
        }
        fn visit_i64<E: de::Error>(self, number: i64) -> Result<String, E> {
            Ok(number.to_string())
        }
    }
    d.deserialize_any(NameVisitor)
}

/// The enum variant `name` that holds an empty table.
struct EmptyVariant<'a, M> {
    name: &'a str,
    empty: M,
}

impl<'de, M: Deserializer<'de>> Deserializer<'de> for EmptyVariant<'_, M> {
    type Error = M::Error;
    fn deserialize_any<V: de::Visitor<'de>>(self, visitor: V) -> Result<V::Value, M::Error> {
        visitor.visit_enum(self)
    }
    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

impl<'de, M: Deserializer<'de>> de::EnumAccess<'de> for EmptyVariant<'_, M> {
    type Error = M::Error;
    type Variant = Self;
    fn variant_seed<V: de::DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), M::Error> {
        Ok((seed.deserialize(de::value::StrDeserializer::new(self.name))?, self))
    }
}

impl<'de, M: Deserializer<'de>> de::VariantAccess<'de> for EmptyVariant<'_, M> {
    type Error = M::Error;
    fn unit_variant(self) -> Result<(), M::Error> {
        Ok(())
    }
    fn newtype_variant_seed<T: de::DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, M::Error> {
        seed.deserialize(self.empty)
    }
    fn tuple_variant<V: de::Visitor<'de>>(self, _len: usize, visitor: V) -> Result<V::Value, M::Error> {
        self.empty.deserialize_any(visitor)
    }
    fn struct_variant<V: de::Visitor<'de>>(
        self,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, M::Error> {
        self.empty.deserialize_any(visitor)
    }
}
