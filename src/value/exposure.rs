//! The exposure of pictures.

use std::fmt;

use serde::{Deserialize, Deserializer, de};

use super::number::finite;

/// The exposure of pictures that are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// The one that suits the scene.
    Auto,
    /// A number of stops: light is shown `2^stops` times as bright.
    Stops(f32),
}

impl Default for Exposure {
    fn default() -> Self {
        Self::Stops(0.0)
    }
}

impl Exposure {
    /// The stops, where they are known without the scene.
    pub fn stops(self) -> Option<f32> {
        match self {
            Self::Auto => None,
            Self::Stops(stops) => Some(stops),
        }
    }
}

const EXPECTED: &str = "a number of stops, such as 1 or -0.5, or `auto`";

impl<'de> Deserialize<'de> for Exposure {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct ExposureVisitor;
        impl de::Visitor<'_> for ExposureVisitor {
            type Value = Exposure;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(EXPECTED)
            }
            fn visit_f64<E: de::Error>(self, v: f64) -> Result<Exposure, E> {
                finite(v).map(Exposure::Stops)
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<Exposure, E> {
                finite(v as f64).map(Exposure::Stops)
            }
            fn visit_str<E: de::Error>(self, v: &str) -> Result<Exposure, E> {
                match v {
                    "auto" => Ok(Exposure::Auto),
                    _ => Err(E::invalid_value(de::Unexpected::Str(v), &self)),
                }
            }
        }
        d.deserialize_any(ExposureVisitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::tests::read;

    #[test]
    fn an_exposure_is_a_finite_number_or_auto() {
        assert_eq!(read("v = -0.5"), Ok(Exposure::Stops(-0.5)));
        assert_eq!(read("v = 'auto'"), Ok(Exposure::Auto));
        assert!(read::<Exposure>("v = inf").is_err());
        assert!(read::<Exposure>("v = 'bright'").is_err());
    }
}
