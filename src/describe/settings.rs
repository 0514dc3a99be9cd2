//! `[render]` and `[output]`: how a scene is rendered and where it goes.

use serde::{Deserialize, Deserializer, de};

use super::SamplesDesc;
use crate::{
    filter::FilterDesc,
    integrator::IntegratorDesc,
    math::WorkingSpace,
    output::{Compression, DisplayTransform, JpegQuality, LightType, NpzCompression, PngBits},
    sampler::{SamplerDesc, SeedMode},
    value::{Count, Exposure, Problem, Spanned, is_override, kind_or_name},
};

/// Size, sampling and integrator of the picture.
///
/// | key | type | default |
/// |---|---|---|
/// | `width`, `height` | size of the picture in pixels | 1280, 720 |
/// | `samples` | samples per pixel, or `{ min, max, threshold }` for adaptive sampling, see below | 64 |
/// | `seed` | seed of the random numbers, a whole number | 0 |
/// | `seed_mode` | `"frame"`: every frame has its own noise, or `"fixed"`: all have the same | `"frame"` |
/// | `sampler` | a sampler | `"sobol"` |
/// | `filter` | a pixel filter | `"blackman-harris"`; with `samples = 1` one ray through the pixel's centre |
/// | `integrator` | an integrator | `"path"` |
/// | `working_space` | the primaries that light is computed with: `"rec709"` or `"acescg"` | `"rec709"` |
///
/// ```toml
/// [render]
/// width = 1920
/// height = 1080
/// samples = 256
/// integrator.path = { max_depth = 12 }
/// ```
///
/// **Adaptive sampling.** A table of `samples` gives every block of 16x16 pixels as many samples as its noise needs:
///
/// ```toml
/// [render]
/// samples = { min = 16, max = 1024, threshold = 0.01 }
/// ```
///
/// | key | type | default |
/// |---|---|---|
/// | `min` | samples that every pixel gets | 16 |
/// | `max` | most samples of a pixel | 1024 |
/// | `threshold` | number of at least 0: the error at which a block has enough samples; 0 gives all pixels `max` | 0.01 |
///
/// The error is that of what is shown: the square root of the mean of `s^2 / max(l, l^2, 0.0015)` over the pixels and channels of
/// the block, where `s` is the estimated standard error of the pixel's channel, and `l` the brightness of the pixel (the mean of
/// its channels), both times `2^exposure`. A display shows light by about its square root, so a threshold of 0.01 leaves a standard
/// error of 0.005 of white, 1.3 of 255 levels. A block is judged when it has a power of two of samples from `min` on, and not
/// before 4. The pass `sampleCount` shows where samples went. A crop renders whole blocks, and its pixels are those of the picture.
///
/// The standard error follows from how much the last doubling of the samples has changed the pixel: `s^2 = d^2 / 1.2`, where `d` is
/// the change, because the variance falls by 2.2 with a doubling. `l` is the brightness of the darker half of the samples, which
/// rare bright ones leave alone. Sources: Dammertz, Hanika, Keller and Lensch, "A Hierarchical Automatic Stopping Condition for
/// Monte Carlo Global Illumination", WSCG 2010, for the halves of the samples and the square root, which Cycles uses, too;
/// [the notes](../notes/adaptive_sampling.md) say how true it is.
///
/// The `max_depth` of an integrator counts ray segments from the camera, shadow rays included, as in Mitsuba: 1 shows only
/// emitters and ambient light, 2 adds direct light, 5 is a camera ray and up to four more.
///
/// Colours of scene files, of models and of images whose `color_space` is `"srgb"` have the primaries of Rec. 709. With
/// `working_space = "acescg"` they are converted to ACEScg, which has more saturated light, and EXR files say so; PNG files are
/// converted back before their view.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RenderDesc {
    pub width: Spanned<Count>,
    pub height: Spanned<Count>,
    pub samples: Spanned<SamplesDesc>,
    pub seed: Count,
    pub seed_mode: SeedMode,
    #[serde(deserialize_with = "some_kind_or_name")]
    pub sampler: Option<SamplerDesc>,
    #[serde(deserialize_with = "some_kind_or_name")]
    pub filter: Option<FilterDesc>,
    #[serde(deserialize_with = "kind_or_name")]
    pub integrator: IntegratorDesc,
    pub working_space: WorkingSpace,
}

impl Default for RenderDesc {
    fn default() -> Self {
        let unsaid = |v| Spanned::new(0..0, Count(v));
        Self {
            width: unsaid(1280),
            height: unsaid(720),
            samples: Spanned::new(0..0, SamplesDesc::Fixed(Count(64))),
            seed: Count(0),
            seed_mode: SeedMode::default(),
            sampler: None,
            filter: None,
            integrator: IntegratorDesc::default(),
            working_space: WorkingSpace::default(),
        }
    }
}

impl RenderDesc {
    /// Width and height.
    pub fn resolution(&self) -> [u32; 2] {
        [&self.width, &self.height].map(|side| side.get_ref().0)
    }

    pub(super) fn check(&self, problems: &mut Vec<Problem>) {
        for (name, value) in [("width", &self.width), ("height", &self.height)] {
            if value.get_ref().0 == 0 {
                problems.push(Problem::at(value.span(), format!("`{name}` must be at least 1")));
            }
        }
        problems.extend(self.samples.get_ref().check(self.samples.span()));
    }
}

fn some_kind_or_name<'de, D: Deserializer<'de>, T: Deserialize<'de>>(d: D) -> Result<Option<T>, D::Error> {
    kind_or_name(d).map(Some)
}

/// Reads file patterns, of which there is at least one.
fn some_files<'de, D: Deserializer<'de>>(d: D) -> Result<Option<OneOrMany>, D::Error> {
    let files = OneOrMany::deserialize(d)?;
    if files.0.is_empty() {
        return Err(de::Error::custom(
            "expected at least one file, such as \"out.####.exr\", found none",
        ));
    }
    Ok(Some(files))
}

/// Which files are written, and how.
///
/// | key | type | default |
/// |---|---|---|
/// | `files` | a file pattern or a list of them, relative to the current folder | `<scene name>.####.exr` and `.png` |
/// | `aovs` | a pass or a list of passes; `"all"`, or `"denoise"` for those of denoisers | none |
/// | `cryptomatte_levels` | mattes of each pixel that Cryptomatte passes keep, an even number up to 16 | 6 |
/// | `show` | a pass | the beauty |
/// | `view` | how PNG, JPEG and other files for displays show light, see below | `"srgb"` |
/// | `exposure` | exposure of such files, in stops, or `"auto"`, see below | 0 |
/// | `compression` | compression of EXR files, see below | `"zips"` |
/// | `png_bits` | bits of PNG files: `"8"`, `"8-dithered"` (smooth shades have noise instead of steps) or `"16"` | `"8"` |
/// | `jpeg_quality` | quality of JPEG files, a whole number from 1 to 100 | 95 |
/// | `npz_compression` | compression of NPZ files: `"none"` (arrays may be mapped) or `"deflate"` | `"none"` |
/// | `exr_type` | numbers of light and normals in EXR files: `"half"` or `"float"` | `"half"` |
/// | `multipart` | whether each layer is a part of its own of an EXR file: `true` or `false` | `false` |
/// | `tiled` | whether EXR files have tiles of 64x64 pixels instead of lines: `true` or `false` | `false` |
///
/// In a file pattern `####` is the frame number with four digits; `%04d` and `$F4` mean the same. The ending selects the
/// format. An EXR file holds scene-linear light with the primaries of Rec. 709, a PNG or JPEG file display values. An NPZ file
/// holds the numbers of EXR files as arrays of NumPy, see [NPZ files](../interface.md#output).
///
/// | view | display values |
/// |---|---|
/// | `"srgb"` | light with the sRGB transfer function |
/// | `"raw"` | values as they are, clamped to 0 and 1 |
/// | `"reinhard"` | bright light compressed by its luminance (Reinhard et al. 2002) |
/// | `"aces"` | the look of ACES for sRGB displays, as fitted by Hill |
/// | `"agx"` | AgX, whose bright colours turn white (Sobotka 2022) |
/// | `"neutral"` | the neutral curve of Khronos: colours below 0.8 stay what they are |
///
/// With `exposure = "auto"` the log-average of the first frame is shown as middle gray: the light of a small picture of it, where
/// there is any, with 16 samples of each pixel. Where it shows surfaces, only these count, not the background behind them and no
/// shadow catchers. At most a tenth of them becomes brighter than 0.8, so that deep shadows do not burn out what is lit. All frames
/// of a job have this exposure, whichever of them a process renders. It is the first frame of the camera path, or the scene's own
/// camera; PNG and JPEG files record the stops.
///
/// | compression | EXR files |
/// |---|---|
/// | `"zips"`, `"zip"` | deflated, a line at a time (read fastest) or 16 lines at a time (smaller) |
/// | `"piz"` | wavelets, 32 lines at a time: smallest where pictures are noisy |
/// | `"rle"`, `"none"` | runs of equal bytes, and nothing |
/// | `"dwaa"` | lossy, for pictures alone: refused in files with passes of data |
///
/// An EXR or NPZ file holds the passes of `aovs` beside the picture. With `show` all files hold that pass alone; a pass of data is
/// rendered with one ray through the centre of each pixel and of the lens, and files for displays show it in a way of its own, see
/// [the list of passes](passes.md).
///
/// ```toml
/// [output]
/// files = ["out/frame.####.exr", "out/preview.####.png"]
/// aovs = ["depth", "N", "lightgroup"]
/// exposure = -0.5
/// ```
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutputDesc {
    #[serde(deserialize_with = "some_files")]
    pub files: Option<OneOrMany>,
    pub aovs: Option<OneOrMany>,
    pub cryptomatte_levels: Option<Spanned<Count>>,
    pub show: Option<Spanned<String>>,
    pub view: DisplayTransform,
    pub exposure: Exposure,
    pub compression: Compression,
    pub exr_type: LightType,
    pub multipart: bool,
    pub tiled: bool,
    pub png_bits: PngBits,
    pub jpeg_quality: JpegQuality,
    pub npz_compression: NpzCompression,
}

/// The numbers that `cryptomatte_levels` may be.
pub const CRYPTOMATTE_LEVELS: &str = "expected an even number from 2 to 16";

/// Whether `cryptomatte_levels` may be `n`.
pub fn are_cryptomatte_levels(n: u32) -> bool {
    (2..=16).contains(&n) && n.is_multiple_of(2)
}

impl OutputDesc {
    pub(super) fn check(&self, problems: &mut Vec<Problem>) {
        if let Some(levels) = &self.cryptomatte_levels
            && !are_cryptomatte_levels(levels.get_ref().0)
        {
            problems.push(Problem::at(
                levels.span(),
                format!("`cryptomatte_levels`: {CRYPTOMATTE_LEVELS}"),
            ));
        }
    }
}

/// One text or several.
#[derive(Clone, Debug)]
pub struct OneOrMany(pub Vec<Spanned<String>>);

impl OneOrMany {
    /// Whether an override gives the texts, and no scene file.
    pub fn is_override(&self) -> bool {
        self.0.iter().any(|text| is_override(&text.span()))
    }
}

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
