//! `samples`: a number of samples, or the limits between which adaptive sampling chooses.

use serde::{Deserialize, Deserializer, de};

use crate::value::{Count, NonNegative, Problem, Span, Spanned, is_override};

/// The samples of each pixel.
#[derive(Clone, Debug, PartialEq)]
pub enum SamplesDesc {
    Fixed(Count),
    Adaptive(AdaptiveDesc),
}

/// Adaptive sampling: blocks of pixels get samples until their noise is below a threshold.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdaptiveDesc {
    pub min: Spanned<Count>,
    pub max: Spanned<Count>,
    /// The display error at which a block has enough samples.
    pub threshold: NonNegative,
}

impl AdaptiveDesc {
    const MIN: u32 = 16;
    const MAX: u32 = 1024;
    const THRESHOLD: f32 = 0.01;
}

impl Default for AdaptiveDesc {
    fn default() -> Self {
        Self {
            min: Spanned::new(0..0, Count(Self::MIN)),
            max: Spanned::new(0..0, Count(Self::MAX)),
            threshold: NonNegative(Self::THRESHOLD),
        }
    }
}

impl SamplesDesc {
    /// The most samples of a pixel.
    pub fn max(&self) -> u32 {
        match self {
            Self::Fixed(Count(samples)) => *samples,
            Self::Adaptive(adaptive) => adaptive.max.get_ref().0,
        }
    }

    /// The parameters of adaptive sampling, if it is enabled.
    pub fn adaptive(&self) -> Option<&AdaptiveDesc> {
        match self {
            Self::Fixed(_) => None,
            Self::Adaptive(adaptive) => Some(adaptive),
        }
    }

    pub(super) fn check(&self, span: Span) -> Option<Problem> {
        let Self::Adaptive(AdaptiveDesc { min, max, .. }) = self else {
            return (self.max() == 0).then(|| Problem::at(span, "`samples` must be at least 1"));
        };
        let overridden = [min, max].map(|count| is_override(&count.span()));
        let at = |count: &Spanned<Count>| Some(count.span()).filter(is_override).unwrap_or(span.clone());
        match (min.get_ref().0, max.get_ref().0) {
            (0, _) => Some(Problem::at(at(min), "`min` must be at least 1")),
            (_, 0) if overridden[1] => Some(Problem::at(at(max), "`samples` must be at least 1")),
            // What replaces one of them lowers the other.
            (min, max) if min > max && overridden == [false; 2] && !is_override(&span) => {
                let message = format!("`max` must be at least `min`, but {max} is less than {min}");
                Some(Problem::at(span, message))
            }
            _ => None,
        }
    }
}

impl<'de> Deserialize<'de> for SamplesDesc {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct SamplesVisitor;
        impl<'de> de::Visitor<'de> for SamplesVisitor {
            type Value = SamplesDesc;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a whole number, or { min, max, threshold }")
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<SamplesDesc, E> {
                Count::deserialize(de::value::I64Deserializer::new(v)).map(SamplesDesc::Fixed)
            }
            fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<SamplesDesc, A::Error> {
                AdaptiveDesc::deserialize(de::value::MapAccessDeserializer::new(map)).map(SamplesDesc::Adaptive)
            }
        }
        d.deserialize_any(SamplesVisitor)
    }
}
