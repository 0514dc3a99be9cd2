//! PNG: pictures for displays, with 8 or 16 bits per channel: the beauty by a view, or another pass by its own display.
//!
//! RGB if the background is visible, else RGBA with straight alpha: light is divided by alpha before the view's curve. Files
//! declare sRGB if the view is, and hold frame, samples, seed, view and the job's metadata as text. A crop is a picture of its
//! own size, with its window as text.

pub mod data;
mod facts;
mod join;
mod picture;

use std::{
    io::{BufReader, Write},
    path::Path,
};

use super::{
    Attribute, Contents, Coverage, EncodeError, Encoding, FileFacts, Format, FrameImage, FrameMetadata, Shown, Value,
    WriteReport,
    display::{DisplayEncoding, quantize, quantize16},
    encode::PngBits,
    join::{CropFile, JoinError},
    seal,
};
use crate::{
    film::{Film, Window},
    math::{hash, parallel},
};

use facts::facts;
pub(super) use facts::{WINDOW, parse_window};
use picture::Picture;

/// The format.
#[derive(Debug)]
pub struct Png;

impl Format for Png {
    fn name(&self) -> &'static str {
        "png"
    }

    fn contents(&self) -> Contents {
        Contents::Picture
    }

    fn encode(&self, frame: &FrameImage, encoding: Encoding, out: &mut dyn Write) -> Result<WriteReport, EncodeError> {
        let window = frame.film.window;
        let (picture, metadata) = (frame.picture(), frame.metadata);
        if window.area() == 0 {
            let (w, h) = (window.width(), window.height());
            return Err(EncodeError::Unfit(format!("a picture of {w} x {h} pixels")));
        }
        let picture = Picture {
            size: [window.width(), window.height()],
            color: match frame.coverage {
                Coverage::Full => ::png::ColorType::Rgb,
                Coverage::Partial => ::png::ColorType::Rgba,
            },
            depth: match encoding.png {
                PngBits::Sixteen => ::png::BitDepth::Sixteen,
                PngBits::Eight | PngBits::Dithered => ::png::BitDepth::Eight,
            },
            is_srgb: picture.spec.pass.is_light() && metadata.view.encoding() == DisplayEncoding::Srgb,
            texts: texts(frame),
            bytes: display_values(frame, encoding.png),
        };
        Ok(WriteReport {
            bytes: picture.write(out)?,
            nans: nans(frame),
            ..WriteReport::default()
        })
    }

    fn facts(&self, path: &Path) -> Option<FileFacts> {
        facts(path).ok().flatten()
    }

    fn inspect(&self, path: &Path) -> Option<FileFacts> {
        inspect(path)
    }

    fn join(&self, crops: &[CropFile], own: &[Attribute]) -> Result<Vec<u8>, JoinError> {
        join::join(crops, own)
    }
}

/// The facts of a file whose seal fits. In a file without a seal, of another program, all pixels must be decodable.
fn inspect(path: &Path) -> Option<FileFacts> {
    let facts = facts(path).ok().flatten()?;
    let is_whole = match seal::is_intact(path).ok()? {
        Some(is_intact) => is_intact,
        None => facts.version().is_none() && decode_pixels(path).is_ok(),
    };
    is_whole.then_some(facts)
}

/// The number of NaNs among the shown values.
pub(super) fn nans(frame: &FrameImage) -> u64 {
    let count = |values: &[f32]| parallel::count(values, |v| v.is_nan()) as u64;
    let alpha = || parallel::count(frame.film.beauty(), |p| p[3].is_nan()) as u64;
    match (frame.shown, frame.picture().spec.pass.is_light()) {
        (Shown::All, _) => count(&frame.picture().values),
        (Shown::Plane(_), true) => count(&frame.picture().values) + alpha(),
        (Shown::Plane(_), false) => alpha(),
    }
}

/// The bytes of all pixels, row by row.
fn display_values(frame: &FrameImage, bits: PngBits) -> Vec<u8> {
    let display = frame.display();
    let straight = |i: usize| {
        let [r, g, b] = frame.channels(i);
        match frame.picture().spec.pass.is_light() {
            true => frame.coverage.shown([r, g, b, frame.film.beauty()[i][3]]),
            false => [r, g, b],
        }
    };
    let alpha = |i: usize| frame.film.beauty()[i][3];
    let pixels = frame.film.window.area();
    match bits {
        PngBits::Eight => {
            let rgb = |i: usize| display.rgb8(straight(i));
            encoded(pixels, frame.coverage, rgb, |i| quantize(alpha(i)))
        }
        PngBits::Dithered => {
            let rgb = |i: usize| display.rgb8_dithered(straight(i), chances(frame.film.window, i));
            encoded(pixels, frame.coverage, rgb, |i| quantize(alpha(i)))
        }
        PngBits::Sixteen => {
            let rgb = |i: usize| display.rgb16(straight(i)).map(u16::to_be_bytes);
            let bytes = encoded(pixels, frame.coverage, rgb, |i| quantize16(alpha(i)).to_be_bytes());
            bytes.into_flattened()
        }
    }
}

/// Random numbers from 0 to 1 for the channels of a pixel, the same in every frame, crop and job.
fn chances(window: Window, pixel: usize) -> [f32; 3] {
    let (column, row) = (pixel as u32 % window.width(), pixel as u32 / window.width());
    let at = [
        window.x0.wrapping_add_unsigned(column),
        window.y0.wrapping_add_unsigned(row),
    ];
    let [r, g, b, _] = hash::pcg4d([at[0] as u32, at[1] as u32, 0x9e37_79b9, 0]);
    [r, g, b].map(hash::unit_f32)
}

/// The values of all pixels: three of `rgb`, and `alpha` if it carries information.
fn encoded<T: Copy + Default + Send>(
    pixels: usize,
    coverage: Coverage,
    rgb: impl Fn(usize) -> [T; 3] + Sync + Send,
    alpha: impl Fn(usize) -> T + Sync + Send,
) -> Vec<T> {
    match coverage {
        Coverage::Full => parallel::table(pixels, rgb).into_flattened(),
        Coverage::Partial => {
            let rgba = |i: usize| {
                let [r, g, b] = rgb(i);
                [r, g, b, alpha(i)]
            };
            parallel::table(pixels, rgba).into_flattened()
        }
    }
}

/// The texts of every file.
fn own_texts(film: &Film, metadata: &FrameMetadata) -> Vec<(String, String)> {
    let version = env!("CARGO_PKG_VERSION");
    let mut texts = vec![
        (seal::NAME.to_owned(), seal::PLACEHOLDER.to_owned()),
        ("Software".to_owned(), format!("batch-render {version}")),
        ("Frame".to_owned(), metadata.frame.to_string()),
        ("Samples".to_owned(), metadata.samples.to_string()),
        ("Seed".to_owned(), metadata.seed.to_string()),
        ("Sampler".to_owned(), metadata.sampler.to_owned()),
    ];
    if film.window != Window::full(film.resolution) {
        texts.push((WINDOW.to_owned(), window_text(film.window, film.resolution)));
    }
    texts
}

/// A window in a picture, such as `4x3+2+1 of 640x480`: columns and rows, and its offset.
fn window_text(window: Window, [width, height]: [u32; 2]) -> String {
    format!("{} of {width}x{height}", Value::Box2i(window))
}

pub(super) fn texts(frame: &FrameImage) -> Vec<(String, String)> {
    let metadata = frame.metadata;
    let mut texts = own_texts(frame.film, metadata);
    if frame.shown != Shown::All {
        texts.push(("Pass".to_owned(), frame.picture().spec.name.clone()));
    }
    if frame.picture().spec.pass.is_light() {
        texts.push(("View".to_owned(), metadata.view.name().to_owned()));
    }
    texts.push(("Exposure".to_owned(), metadata.exposure.to_string()));
    texts.extend(given_texts(metadata));
    texts
}

/// The texts that the job adds, including the fingerprint.
fn given_texts(metadata: &FrameMetadata) -> impl Iterator<Item = (String, String)> {
    let given = metadata.attributes.iter().filter(|a| is_keyword(&a.name));
    given.map(|a| (a.name.clone(), a.value.to_string()))
}

/// Whether the name is a valid keyword. Of Latin-1, only ASCII is used here.
fn is_keyword(name: &str) -> bool {
    let is_trimmed = !name.starts_with(' ') && !name.ends_with(' ') && !name.contains("  ");
    (1..80).contains(&name.len()) && is_trimmed && name.bytes().all(|b| matches!(b, b' '..=b'~'))
}

/// Decodes all rows and checks the checksums of all chunks.
fn decode_pixels(path: &Path) -> Result<(), ::png::DecodingError> {
    let mut decoder = ::png::Decoder::new(BufReader::new(super::facts::open(path)?));
    decoder.ignore_checksums(false);
    let mut reader = decoder.read_info()?;
    while reader.next_row()?.is_some() {}
    reader.finish()
}

#[cfg(test)]
mod tests;
