//! `[render]` and `[output]`: how a scene is rendered and where it goes.

use serde::{Deserialize, Deserializer, de};

use crate::{
    filter::FilterDesc,
    integrator::IntegratorDesc,
    sampler::{SamplerDesc, SeedMode},
    value::{Problem, Real, Spanned, Whole, named},
};

/// `[render]`.
///
/// | key | type | default |
/// |---|---|---|
/// | `width`, `height` | whole numbers above 0, in pixels | 1280, 720 |
/// | `samples` | whole number above 0, of each pixel | 64 |
/// | `seed` | whole number | 0 |
/// | `seed_mode` | `"frame"`: the noise changes from frame to frame, `"fixed"`: it stays | `"frame"` |
/// | `sampler` | a sampler | `sobol` |
/// | `filter` | a pixel filter | `blackman-harris`; with `samples = 1` one ray through the pixel's centre |
/// | `integrator` | an integrator | `path` |
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RenderDesc {
    pub width: Spanned<Whole>,
    pub height: Spanned<Whole>,
    pub samples: Spanned<Whole>,
    pub seed: Whole,
    pub seed_mode: SeedMode,
    #[serde(deserialize_with = "some_named")]
    pub sampler: Option<SamplerDesc>,
    #[serde(deserialize_with = "some_named")]
    pub filter: Option<FilterDesc>,
    #[serde(deserialize_with = "some_named")]
    pub integrator: Option<IntegratorDesc>,
}

impl Default for RenderDesc {
    fn default() -> Self {
        let unsaid = |v| Spanned::new(0..0, Whole(v));
        Self {
            width: unsaid(1280),
            height: unsaid(720),
            samples: unsaid(64),
            seed: Whole(0),
            seed_mode: SeedMode::default(),
            sampler: None,
            filter: None,
            integrator: None,
        }
    }
}

impl RenderDesc {
    pub(super) fn check(&self, problems: &mut Vec<Problem>) {
        for (name, value) in [
            ("width", &self.width),
            ("height", &self.height),
            ("samples", &self.samples),
        ] {
            if value.get_ref().0 == 0 {
                problems.push(Problem::at(value.span(), format!("`{name}` must be at least 1")));
            }
        }
    }
}

fn some_named<'de, D: Deserializer<'de>, T: Deserialize<'de>>(d: D) -> Result<Option<T>, D::Error> {
    named(d).map(Some)
}

/// `[output]`.
///
/// | key | type | default |
/// |---|---|---|
/// | `files` | a pattern or a list of patterns, relative to the current folder | `<scene name>.####.exr` and `.png` |
/// | `aovs` | a pass or a list of passes that EXR files hold beside the beauty; `"all"` for every pass | none |
/// | `show` | a pass that files show in place of the beauty | the beauty |
/// | `view` | how a PNG shows light: `"srgb"` or `"raw"` | `"srgb"` |
/// | `exposure` | stops, for the PNG | 0 |
/// | `compression` | of the EXR: `"zips"`, `"zip"` or `"none"` | `"zips"` |
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutputDesc {
    pub files: Option<OneOrMany>,
    pub aovs: Option<OneOrMany>,
    pub show: Option<Spanned<String>>,
    pub view: Option<Spanned<String>>,
    pub exposure: Option<Real>,
    pub compression: Option<Spanned<String>>,
}

/// One text or several.
#[derive(Clone, Debug)]
pub struct OneOrMany(pub Vec<Spanned<String>>);

impl<'de> Deserialize<'de> for OneOrMany {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct OneOrManyVisitor;
        impl<'de> de::Visitor<'de> for OneOrManyVisitor {
            type Value = Vec<Spanned<String>>;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a text or a list of texts")
            }
            fn visit_str<E: de::Error>(self, v: &str) -> Result<Self::Value, E> {
                Ok(vec![Spanned::new(0..0, v.to_owned())])
            }
            fn visit_seq<A: de::SeqAccess<'de>>(self, seq: A) -> Result<Self::Value, A::Error> {
                Vec::deserialize(de::value::SeqAccessDeserializer::new(seq))
            }
        }
        // The span of the whole stands in for that of a single text.
        let whole: Spanned<Texts> = Spanned::deserialize(d)?;
        let span = whole.span();
        let located = |text: Spanned<String>| match text.span().is_empty() {
            true => Spanned::new(span.clone(), text.into_inner()),
            false => text,
        };
        return Ok(Self(whole.into_inner().0.into_iter().map(located).collect()));

        struct Texts(Vec<Spanned<String>>);
        impl<'de> Deserialize<'de> for Texts {
            fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                d.deserialize_any(OneOrManyVisitor).map(Texts)
            }
        }
    }
}
