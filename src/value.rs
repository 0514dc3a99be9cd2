//! The words of scene files: numbers, points, directions and colours that check themselves while they are read, so that
//! an error points at the very value, and the problems that a closer look finds.

use std::{error, fmt, marker::PhantomData, ops::Range};

use glam::Vec3;
use serde::{Deserialize, Deserializer, de};
pub use serde_spanned::Spanned;

use crate::math::Rgb;

/// Byte offsets into a scene file.
pub type Span = Range<usize>;

/// Something wrong with a description, and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    pub span: Option<Span>,
    pub message: String,
    /// What to do about it, where that is known.
    pub help: Option<String>,
}

impl Problem {
    pub fn at(span: Span, message: impl Into<String>) -> Self {
        Self {
            span: Some(span),
            message: message.into(),
            help: None,
        }
    }

    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// The candidate nearest to `word` in spelling, if it is near enough to be what was meant.
pub fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    candidates
        .into_iter()
        .map(|c| (strsim::damerau_levenshtein(&lower, &c.to_lowercase()), c))
        .filter(|(distance, c)| *distance <= 1 + c.len().min(word.len()) / 4)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, c)| c)
}

/// A name that is not known.
///
/// Displayed on one line: "unknown key `radus` (did you mean `radius`?)".
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownName {
    /// The message, without the help.
    message: String,
    /// The name that was probably meant.
    suggestion: Option<String>,
    /// The help where no known name is similar.
    fallback: Option<String>,
}

impl UnknownName {
    /// A `name` that is not among the `known` ones. `what` says what it is the name of, such as "key" or "format".
    pub fn new<'a>(what: &str, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        let known: Vec<&str> = known.into_iter().collect();
        Self {
            message: format!("unknown {what} `{name}`"),
            suggestion: did_you_mean(name, known.iter().copied()).map(str::to_owned),
            fallback: Some(if known.is_empty() {
                format!("no {what} is allowed here")
            } else {
                format!("expected {}", one_of(known))
            }),
        }
    }

    /// The same with another help text, or with none, where no known name is similar.
    pub fn with_fallback(mut self, help: Option<String>) -> Self {
        self.fallback = help;
        self
    }

    /// The known name that was probably meant.
    pub fn suggestion(&self) -> Option<&str> {
        self.suggestion.as_deref()
    }

    /// How to correct the name.
    pub fn help(&self) -> Option<String> {
        match &self.suggestion {
            Some(name) => Some(format!("did you mean `{name}`?")),
            None => self.fallback.clone(),
        }
    }

    /// The problem of the name at `span` in a scene file.
    pub fn at(&self, span: Span) -> Problem {
        Problem {
            span: Some(span),
            message: self.message.clone(),
            help: self.help(),
        }
    }
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        match self.help() {
            Some(help) => write!(f, " ({help})"),
            None => Ok(()),
        }
    }
}

impl error::Error for UnknownName {}

/// The text "one of `a`, `b`".
pub fn one_of<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let quoted: Vec<_> = names.into_iter().map(|name| format!("`{name}`")).collect();
    format!("one of {}", quoted.join(", "))
}

/// Any number, whole or not.
fn number<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    struct NumberVisitor;
    impl de::Visitor<'_> for NumberVisitor {
        type Value = f64;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a number")
        }
        fn visit_f64<E: de::Error>(self, v: f64) -> Result<f64, E> {
            Ok(v)
        }
        fn visit_i64<E: de::Error>(self, v: i64) -> Result<f64, E> {
            Ok(v as f64)
        }
    }
    d.deserialize_any(NumberVisitor)
}

/// A whole number from 0 to 2^32 - 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Whole(pub u32);

impl<'de> Deserialize<'de> for Whole {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct WholeVisitor;
        impl de::Visitor<'_> for WholeVisitor {
            type Value = Whole;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a whole number from 0 to {}", u32::MAX)
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<Whole, E> {
                let whole = u32::try_from(v).map_err(|_| E::invalid_value(de::Unexpected::Signed(v), &self))?;
                Ok(Whole(whole))
            }
        }
        d.deserialize_any(WholeVisitor)
    }
}

fn finite<E: de::Error>(v: f64) -> Result<f32, E> {
    let single = v as f32;
    if single.is_finite() {
        Ok(single)
    } else if v.is_finite() {
        Err(E::custom(format_args!("{v:e} is too large")))
    } else {
        Err(E::custom(format_args!("expected a finite number, found {v}")))
    }
}

macro_rules! number {
    ($(#[$meta:meta])* $Name:ident, $what:literal, $ok:expr) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
        pub struct $Name(pub f32);

        impl<'de> Deserialize<'de> for $Name {
            fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                let v = finite::<D::Error>(number(d)?)?;
                let ok: fn(f32) -> bool = $ok;
                if ok(v) {
                    Ok(Self(v))
                } else {
                    Err(de::Error::custom(format_args!(concat!("expected ", $what, ", found {}"), v)))
                }
            }
        }

        impl From<$Name> for f32 {
            fn from(v: $Name) -> f32 {
                v.0
            }
        }
    };
}

number!(
    /// Any finite number.
    Real,
    "a finite number",
    |_| true
);
number!(
    /// A finite number above 0: a radius, a height, a width.
    Positive,
    "a number above 0",
    |v| v > 0.0
);
number!(
    /// A finite number of at least 0.
    NonNegative,
    "a number of at least 0",
    |v| v >= 0.0
);
number!(
    /// A finite number from 0 to 1.
    Unit,
    "a number from 0 to 1",
    |v| (0.0..=1.0).contains(&v)
);

/// A point or an offset: three finite numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point(pub Vec3);

impl<'de> Deserialize<'de> for Point {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let [x, y, z] = <[Real; 3]>::deserialize(d)?;
        Ok(Self(Vec3::new(x.0, y.0, z.0)))
    }
}

/// A direction: three finite numbers, not all 0. Held as a unit vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction(pub Vec3);

impl<'de> Deserialize<'de> for Direction {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let Point(v) = Point::deserialize(d)?;
        let unit = v.as_dvec3().try_normalize();
        unit.map(|u| Self(u.as_vec3()))
            .ok_or_else(|| de::Error::custom("expected a direction, found a vector of length 0"))
    }
}

/// A weight for each channel, none of them negative: one number for all three, or `[r, g, b]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tint(pub Rgb);

impl<'de> Deserialize<'de> for Tint {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct TintVisitor;
        impl<'de> de::Visitor<'de> for TintVisitor {
            type Value = Tint;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or [r, g, b]")
            }
            fn visit_f64<E: de::Error>(self, v: f64) -> Result<Tint, E> {
                Ok(Tint(Rgb::gray(not_negative(finite(v)?)?)))
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<Tint, E> {
                self.visit_f64(v as f64)
            }
            fn visit_seq<A: de::SeqAccess<'de>>(self, seq: A) -> Result<Tint, A::Error> {
                color_from_seq(seq).map(Tint)
            }
        }
        d.deserialize_any(TintVisitor)
    }
}

fn not_negative<E: de::Error>(v: f32) -> Result<f32, E> {
    if v >= 0.0 {
        Ok(v)
    } else {
        Err(E::custom(format_args!("expected a number of at least 0, found {v}")))
    }
}

fn color_from_seq<'de, A: de::SeqAccess<'de>>(seq: A) -> Result<Rgb, A::Error> {
    let channels = <[NonNegative; 3]>::deserialize(de::value::SeqAccessDeserializer::new(seq))?;
    Ok(Rgb::from_array(channels.map(f32::from)))
}

/// A colour that may vary over a surface: a number (gray), `[r, g, b]` (scene-linear), or `"texture.NAME"`.
#[derive(Clone, Debug, PartialEq)]
pub enum ColorSource {
    Constant(Rgb),
    /// The name of a texture of the same file.
    Texture(String),
    /// A texture times a colour: models have such, scene files cannot write it.
    Tinted {
        texture: String,
        tint: Rgb,
    },
}

impl<'de> Deserialize<'de> for ColorSource {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct SourceVisitor;
        impl<'de> de::Visitor<'de> for SourceVisitor {
            type Value = ColorSource;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, [r, g, b] or \"texture.NAME\"")
            }
            fn visit_f64<E: de::Error>(self, v: f64) -> Result<ColorSource, E> {
                Ok(ColorSource::Constant(Rgb::gray(not_negative(finite(v)?)?)))
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<ColorSource, E> {
                self.visit_f64(v as f64)
            }
            fn visit_str<E: de::Error>(self, v: &str) -> Result<ColorSource, E> {
                match v.strip_prefix("texture.") {
                    Some(name) if !name.is_empty() => Ok(ColorSource::Texture(name.to_owned())),
                    _ => Err(E::invalid_value(de::Unexpected::Str(v), &self)),
                }
            }
            fn visit_seq<A: de::SeqAccess<'de>>(self, seq: A) -> Result<ColorSource, A::Error> {
                color_from_seq(seq).map(ColorSource::Constant)
            }
        }
        d.deserialize_any(SourceVisitor)
    }
}

/// One of the numbers of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    R,
    G,
    B,
    /// Opacity: 1 where a picture has none.
    A,
}

impl Channel {
    fn from_letter(letter: &str) -> Option<Self> {
        match letter {
            "r" => Some(Self::R),
            "g" => Some(Self::G),
            "b" => Some(Self::B),
            "a" => Some(Self::A),
            _ => None,
        }
    }
}

/// A number of at least 0 that may vary over a surface: a number, `"texture.NAME"`, or a channel of it: `"texture.NAME.g"`.
#[derive(Clone, Debug, PartialEq)]
pub enum ScalarSource {
    Constant(f32),
    Texture {
        /// The name of a texture of the same file.
        name: String,
        /// Where none is said, each use has its own.
        channel: Option<Channel>,
    },
}

impl<'de> Deserialize<'de> for ScalarSource {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct SourceVisitor;
        impl de::Visitor<'_> for SourceVisitor {
            type Value = ScalarSource;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, \"texture.NAME\" or \"texture.NAME.r\" (or g, b, a)")
            }
            fn visit_f64<E: de::Error>(self, v: f64) -> Result<ScalarSource, E> {
                Ok(ScalarSource::Constant(not_negative(finite(v)?)?))
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<ScalarSource, E> {
                self.visit_f64(v as f64)
            }
            fn visit_str<E: de::Error>(self, v: &str) -> Result<ScalarSource, E> {
                let wrong = || E::invalid_value(de::Unexpected::Str(v), &self);
                let whole = v.strip_prefix("texture.").filter(|n| !n.is_empty()).ok_or_else(wrong)?;
                let (name, channel) = match whole.rsplit_once('.') {
                    Some((name, letter)) if !name.is_empty() => {
                        (name, Some(Channel::from_letter(letter).ok_or_else(wrong)?))
                    }
                    _ => (whole, None),
                };
                let name = name.to_owned();
                Ok(ScalarSource::Texture { name, channel })
            }
        }
        d.deserialize_any(SourceVisitor)
    }
}

/// The kind `name` with all its keys left out.
pub fn by_name<T: de::DeserializeOwned>(name: &str, known: &[&str]) -> Result<T, String> {
    if !known.contains(&name) {
        return Err(match did_you_mean(name, known.iter().copied()) {
            Some(near) => format!("unknown name '{name}', did you mean '{near}'?"),
            None => format!("unknown name '{name}', known are {}", known.join(", ")),
        });
    }
    named(de::value::StrDeserializer::<de::value::Error>::new(name)).map_err(|e| e.to_string())
}

/// Reads an externally tagged kind, where a bare `"NAME"` is short for `NAME = {}`.
///
/// For `#[serde(deserialize_with = "value::named")]`.
pub fn named<'de, D: Deserializer<'de>, T: Deserialize<'de>>(d: D) -> Result<T, D::Error> {
    struct NamedVisitor<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> de::Visitor<'de> for NamedVisitor<T> {
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
    d.deserialize_any(NamedVisitor(PhantomData))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Deserialize)]
    struct Row<T> {
        v: T,
    }

    fn read<T: de::DeserializeOwned>(text: &str) -> Result<T, String> {
        toml::from_str::<Row<T>>(text)
            .map(|r| r.v)
            .map_err(|e| e.message().to_owned())
    }

    #[test]
    fn numbers_say_what_they_expect() {
        assert_eq!(read::<Positive>("v = 2"), Ok(Positive(2.0)));
        assert_eq!(
            read::<Positive>("v = -1"),
            Err("expected a number above 0, found -1".into())
        );
        assert_eq!(
            read::<Real>("v = nan"),
            Err("expected a finite number, found NaN".into())
        );
        assert_eq!(read::<Real>("v = 1e300"), Err("1e300 is too large".into()));
    }

    #[test]
    fn colors_are_numbers_or_textures() {
        assert_eq!(
            read::<ColorSource>("v = 'texture.a'"),
            Ok(ColorSource::Texture("a".into()))
        );
        assert_eq!(
            read::<ColorSource>("v = [1, 0.5, 0]"),
            Ok(ColorSource::Constant(Rgb::new(1.0, 0.5, 0.0)))
        );
        assert_eq!(read::<ColorSource>("v = 2"), Ok(ColorSource::Constant(Rgb::gray(2.0))));
        assert_eq!(
            read::<ColorSource>("v = [1, -0.5, 0]"),
            Err("expected a number of at least 0, found -0.5".into())
        );
        assert!(read::<ColorSource>("v = 'red'").is_err());
        assert_eq!(read::<Tint>("v = 0.8"), Ok(Tint(Rgb::gray(0.8))));
    }

    #[test]
    fn scalars_are_numbers_or_channels_of_textures() {
        let texture = |name: &str, channel| {
            let name = name.to_owned();
            Ok(ScalarSource::Texture { name, channel })
        };
        assert_eq!(read("v = 0.5"), Ok(ScalarSource::Constant(0.5)));
        assert_eq!(read("v = 'texture.a'"), texture("a", None));
        assert_eq!(read("v = 'texture.a.g'"), texture("a", Some(Channel::G)));
        assert!(read::<ScalarSource>("v = 'texture.a.x'").is_err());
        assert!(read::<ScalarSource>("v = -1").is_err());
    }

    #[test]
    fn near_words_are_suggested_and_far_ones_are_not() {
        assert_eq!(did_you_mean("radus", ["center", "radius"]), Some("radius"));
        assert_eq!(did_you_mean("colour", ["center", "color"]), Some("color"));
        assert_eq!(did_you_mean("banana", ["center", "radius"]), None);
    }
}
