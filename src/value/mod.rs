//! The values of scene files: numbers, points, directions and colours.
//!
//! Each type validates itself while it is deserialized, so that an error points at the value that
//! is wrong. A [`Problem`] is an error that is found later, when a description is compiled.

use std::ops::Range;

pub use serde_spanned::Spanned;

mod color;
mod exposure;
mod hex;
mod kinds;
mod list;
mod names;
mod number;
mod shown;
mod unique;
mod wildcard;

pub use color::{Channel, ColorSource, RgbFactor, ScalarSource};
pub use exposure::Exposure;
pub use kinds::{kind_or_name, name};
pub use list::List;
pub use names::{UnknownName, one_of, unknown_name};
pub use number::{
    Coordinate, Count, Direction, Finite, NonNegative, OneOrEach, Point, Positive, Precise, PrecisePositive, Scale,
    SpaceScale, Stops, UnitInterval, number,
};
pub use shown::{one_line, visible};
pub use unique::unique_names;
pub use wildcard::matches_wildcards;

/// Byte offsets into a scene file.
pub type Span = Range<usize>;

/// The first of the spans that are in no file: they number the values that override those of files. No file is that long.
pub const OVERRIDES: usize = 1 << (usize::BITS - 2);

/// Whether a value with this span overrides one of a file.
pub fn is_override(span: &Span) -> bool {
    span.start >= OVERRIDES
}

/// An error in a description, and where it is in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    pub span: Option<Span>,
    pub message: String,
    /// A hint for the correction, where there is one.
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

#[cfg(test)]
mod tests {
    use serde::{Deserialize, de::DeserializeOwned};

    #[derive(Debug, Deserialize)]
    struct Entry<T> {
        v: T,
    }

    /// The value of `v` in a TOML text, or the message of its error.
    pub(super) fn read<T: DeserializeOwned>(text: &str) -> Result<T, String> {
        toml::from_str::<Entry<T>>(text)
            .map(|entry| entry.v)
            .map_err(|e| e.message().to_owned())
    }
}
