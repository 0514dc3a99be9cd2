//! The quality of JPEG files.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{self, Unexpected},
};

/// The quality of files, from 1 to 100, by which the Independent JPEG Group scales its tables of quantization.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct JpegQuality(u8);

impl Default for JpegQuality {
    fn default() -> Self {
        Self(95)
    }
}

impl JpegQuality {
    pub(super) fn get(self) -> u8 {
        self.0
    }

    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

impl<'de> Deserialize<'de> for JpegQuality {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct QualityVisitor;
        impl de::Visitor<'_> for QualityVisitor {
            type Value = JpegQuality;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a whole number from 1 to 100")
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<JpegQuality, E> {
                let quality = u8::try_from(v).ok().filter(|quality| (1..=100).contains(quality));
                let refused = || E::invalid_value(Unexpected::Signed(v), &self);
                quality.map(JpegQuality).ok_or_else(refused)
            }
        }
        d.deserialize_any(QualityVisitor)
    }
}
