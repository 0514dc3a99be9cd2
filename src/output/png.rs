//! PNG: the beauty through its view, 8 bits a channel.
//!
//! RGB where the background is visible, RGBA with straight alpha otherwise. The light is divided by its alpha before the view's
//! curve. The file says sRGB where the view is, and carries frame, samples, seed, view and the job's metadata as text. A crop is
//! a picture of the crop's size.

use std::{
    fs::File,
    io::{self, BufReader, Read, Seek, SeekFrom, Write},
    path::Path,
};

use rayon::prelude::*;

use super::{
    Attribute, Contents, Counting, Coverage, EncodeError, Encoding, FileFacts, Format, FrameImage, WriteReport,
};
use crate::{
    film::view::{Tag, quantize},
    math::Rgb,
};

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

    fn encode(&self, frame: &FrameImage, _: Encoding, out: &mut dyn Write) -> Result<WriteReport, EncodeError> {
        let window = frame.window;
        if window.pixels() == 0 || frame.rgba.len() != window.pixels() {
            let (n, w, h) = (frame.rgba.len(), window.width, window.height);
            return Err(EncodeError::Unfit(format!("{n} pixels for a window of {w} x {h}")));
        }
        let mut out = Counting { out, bytes: 0 };
        let mut encoder = ::png::Encoder::new(&mut out, window.width, window.height);
        encoder.set_depth(::png::BitDepth::Eight);
        encoder.set_color(match frame.coverage {
            Coverage::Full => ::png::ColorType::Rgb,
            Coverage::Partial => ::png::ColorType::Rgba,
        });
        // 8 ms for 1080p; the default takes 15 times as long for 11 % less.
        encoder.set_compression(::png::Compression::Fast);
        if frame.view.tag() == Tag::Srgb {
            encoder.set_source_srgb(::png::SrgbRenderingIntent::Perceptual);
        }
        for (key, text) in texts(frame) {
            add_text(&mut encoder, key, text).map_err(error)?;
        }
        let mut writer = encoder.write_header().map_err(error)?;
        writer.write_image_data(&display_values(frame)).map_err(error)?;
        writer.finish().map_err(error)?;
        let (clamped, nans) = (
            0,
            frame.rgba.as_flattened().par_iter().filter(|v| v.is_nan()).count() as u64,
        );
        Ok(WriteReport {
            bytes: out.bytes,
            clamped,
            nans,
        })
    }

    fn inspect(&self, path: &Path) -> Option<FileFacts> {
        facts(path).ok().flatten()
    }
}

/// The bytes of all pixels, row by row.
fn display_values(frame: &FrameImage) -> Vec<u8> {
    let display = frame.view.with_exposure(frame.exposure);
    match frame.coverage {
        Coverage::Full => {
            let pixel = |[r, g, b, _]: &[f32; 4]| display.rgb8(Rgb::new(*r, *g, *b));
            let pixels: Vec<_> = frame.rgba.par_iter().with_min_len(4096).map(pixel).collect();
            pixels.into_flattened()
        }
        Coverage::Partial => {
            let pixel = |[r, g, b, a]: &[f32; 4]| {
                let light = Rgb::new(*r, *g, *b);
                // Light where nothing covers the pixel has no colour to divide out.
                let straight = if *a > 0.0 { light / *a } else { light };
                let [r, g, b] = display.rgb8(straight);
                [r, g, b, quantize(*a)]
            };
            let pixels: Vec<_> = frame.rgba.par_iter().with_min_len(4096).map(pixel).collect();
            pixels.into_flattened()
        }
    }
}

fn texts(frame: &FrameImage) -> Vec<(String, String)> {
    let version = env!("CARGO_PKG_VERSION");
    let mut texts = vec![
        ("Software".to_owned(), format!("batch-render {version}")),
        ("Frame".to_owned(), frame.frame.to_string()),
        ("Samples".to_owned(), frame.samples.to_string()),
        ("Seed".to_owned(), frame.seed.to_string()),
        ("Sampler".to_owned(), frame.sampler.to_owned()),
        ("View".to_owned(), frame.view.name().to_owned()),
        ("Exposure".to_owned(), frame.exposure.to_string()),
    ];
    let given = frame.metadata.iter().filter(|a| is_keyword(&a.name));
    texts.extend(given.map(|a| (a.name.clone(), a.value.to_string())));
    texts
}

/// Whether the format can put a text under this name; of Latin-1, ASCII is enough here.
fn is_keyword(name: &str) -> bool {
    let is_trimmed = !name.starts_with(' ') && !name.ends_with(' ') && !name.contains("  ");
    (1..80).contains(&name.len()) && is_trimmed && name.bytes().all(|b| matches!(b, b' '..=b'~'))
}

/// Adds ASCII as plain text and any other as UTF-8: the format's Latin-1 is what many readers get wrong.
fn add_text<W: Write>(encoder: &mut ::png::Encoder<W>, key: String, text: String) -> Result<(), ::png::EncodingError> {
    if text.bytes().all(|b| matches!(b, b'\n' | b' '..=b'~')) {
        encoder.add_text_chunk(key, text)
    } else {
        encoder.add_itxt_chunk(key, text)
    }
}

fn error(error: ::png::EncodingError) -> EncodeError {
    match error {
        ::png::EncodingError::IoError(source) => EncodeError::Io(source),
        other => EncodeError::Unfit(other.to_string()),
    }
}

/// The facts of a file that begins as a PNG and ends with the chunk that ends one.
fn facts(path: &Path) -> io::Result<Option<FileFacts>> {
    const BEGIN: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
    const END: [u8; 12] = *b"\0\0\0\0IEND\xaeB`\x82";
    let mut file = BufReader::new(File::open(path)?);
    let (mut begin, mut end) = ([0; BEGIN.len()], [0; END.len()]);
    file.read_exact(&mut begin)?;
    file.seek(SeekFrom::End(-(END.len() as i64)))?;
    file.read_exact(&mut end)?;
    if begin != BEGIN || end != END {
        return Ok(None);
    }
    file.seek(SeekFrom::Start(BEGIN.len() as u64))?;
    let (mut resolution, mut attributes) = (None, Vec::new());
    loop {
        let (mut size, mut kind, mut checksum) = ([0; 4], [0; 4], [0; 4]);
        file.read_exact(&mut size)?;
        file.read_exact(&mut kind)?;
        let size = u32::from_be_bytes(size) as usize;
        match &kind {
            // Our texts come before the pixels.
            b"IDAT" | b"IEND" => break,
            b"IHDR" | b"tEXt" | b"iTXt" if size <= FileFacts::MAX_ATTRIBUTE => {
                let mut bytes = vec![0; size];
                file.read_exact(&mut bytes)?;
                match bytes.as_chunks::<4>().0 {
                    [width, height, ..] if &kind == b"IHDR" => {
                        resolution = Some([width, height].map(|side| u32::from_be_bytes(*side)));
                    }
                    _ => attributes.extend(text_of(&kind, &bytes)),
                }
                file.read_exact(&mut checksum)?;
            }
            _ => file.seek_relative(size as i64 + 4)?,
        }
    }
    Ok(resolution.map(|resolution| FileFacts { resolution, attributes }))
}

/// The text of a `tEXt` or of an uncompressed `iTXt` chunk under its keyword.
fn text_of(kind: &[u8; 4], bytes: &[u8]) -> Option<Attribute> {
    let (keyword, mut text) = split_at_zero(bytes)?;
    if kind == b"iTXt" {
        let rest = text.strip_prefix(&[0, 0])?;
        let (_language, rest) = split_at_zero(rest)?;
        (_, text) = split_at_zero(rest)?;
    }
    let (keyword, text) = (str::from_utf8(keyword).ok()?, str::from_utf8(text).ok()?);
    Some(Attribute::new(keyword, text))
}

fn split_at_zero(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().position(|b| *b == 0)?;
    Some((&bytes[..end], &bytes[end + 1..]))
}

#[cfg(test)]
mod tests;
