//! Colours, and the sources of colours and numbers that may vary over a surface.

use std::fmt;

use serde::{Deserialize, Deserializer, de};

use super::hex::in_hex;
use super::number::{NonNegative, OneOrEach, finite, not_negative};
use crate::math::Rgb;

/// A non-negative factor for each channel: one number for all three, or `[r, g, b]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RgbFactor(pub Rgb);

impl RgbFactor {
    pub fn white() -> Self {
        Self(Rgb::WHITE)
    }

    pub fn black() -> Self {
        Self(Rgb::BLACK)
    }
}

impl<'de> Deserialize<'de> for RgbFactor {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let OneOrEach(channels) = OneOrEach::<NonNegative, 3>::deserialize(d)?;
        Ok(Self(Rgb::from_array(channels.map(f32::from))))
    }
}

/// A colour that may vary over a surface: a number (gray), `[r, g, b]` (scene-linear), or
/// `"texture.NAME"`.
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
                    _ => Err(in_hex(v).unwrap_or_else(|| E::invalid_value(de::Unexpected::Str(v), &self))),
                }
            }
            fn visit_seq<A: de::SeqAccess<'de>>(self, seq: A) -> Result<ColorSource, A::Error> {
                let RgbFactor(color) = RgbFactor::deserialize(de::value::SeqAccessDeserializer::new(seq))?;
                Ok(ColorSource::Constant(color))
            }
        }
        d.deserialize_any(SourceVisitor)
    }
}

/// A channel of a texel.
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

/// A number of at least 0 that may vary over a surface: a number, `"texture.NAME"`, or a channel of
/// it: `"texture.NAME.g"`.
#[derive(Clone, Debug, PartialEq)]
pub enum ScalarSource {
    Constant(f32),
    Texture {
        /// The name of a texture of the same file.
        name: String,
        /// The default depends on the use.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::tests::read;

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
        assert_eq!(read::<RgbFactor>("v = 0.8"), Ok(RgbFactor(Rgb::gray(0.8))));
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
}
