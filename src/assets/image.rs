//! Pictures: PNG, JPEG, BMP, TGA, WebP, HDR and EXR files to texels.
//!
//! The content decides the format, the extension only where the content has no signature (TGA). Row 0 is the top row, as it is
//! displayed; an Exif orientation is ignored. Integer formats are display values or data, as the caller says; HDR and EXR are
//! scene-linear whatever it says. 8-bit texels stay 8-bit and are looked up; deeper ones become floats.
//!
//! A file that ends early, is damaged or claims an absurd size is an error, never a picture with gray in it.

mod error;
mod exr;
mod limits;

use std::{io::Cursor, path::Path, sync::LazyLock};

use super::{Files, MemoryBudget, MemoryKind};
use crate::{
    math::srgb,
    texture::bitmap::{Bitmap, ColorSpace, Storage},
};
use ::image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use error::ImageProblem;
use limits::{MAX_BYTES, MAX_SIDE, check_size, with_levels};

pub use error::ImageError;

/// Decodes the file at `path`.
pub fn load(path: &Path, color_space: ColorSpace, files: &Files) -> Result<Bitmap, ImageError> {
    let bytes = files.read(path).map_err(|source| ImageError::Read {
        source,
        path: path.to_owned(),
    })?;
    decode(&bytes, path, color_space, files.memory())
}

/// Decodes a file in memory; `path` is what errors call it, and its extension helps where the bytes do not tell.
pub fn decode(bytes: &[u8], path: &Path, color_space: ColorSpace, memory: &MemoryBudget) -> Result<Bitmap, ImageError> {
    let decoded = if bytes.starts_with(&exr::MAGIC) {
        exr::decode(bytes, memory)
    } else {
        decode_by_format(bytes, path, color_space, memory)
    };
    decoded.map_err(|problem| problem.at(path))
}

/// Whether the picture at `path` has an alpha channel, by its header. A file that cannot be read has none, and neither has an
/// EXR file.
pub fn has_alpha(path: &Path, files: &Files) -> bool {
    let Ok(bytes) = files.read(path) else { return false };
    let format = ::image::guess_format(&bytes).or_else(|_| ImageFormat::from_path(path));
    let decoder = format.map(|f| ImageReader::with_format(Cursor::new(&bytes), f).into_decoder());
    matches!(decoder, Ok(Ok(decoder)) if decoder.color_type().has_alpha())
}

fn decode_by_format(
    bytes: &[u8],
    path: &Path,
    color_space: ColorSpace,
    memory: &MemoryBudget,
) -> Result<Bitmap, ImageProblem> {
    let format = ::image::guess_format(bytes).or_else(|_| ImageFormat::from_path(path));
    let format = format
        .ok()
        .filter(ImageFormat::reading_enabled)
        .ok_or(ImageProblem::Unknown)?;
    if format == ImageFormat::Jpeg && !jpeg_has_an_end(bytes) {
        // The decoder would fill up with gray.
        return Err(ImageProblem::broken("unexpected end of file"));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_BYTES);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let decoder = reader
        .into_decoder()
        .map_err(|e| empty(bytes, format).unwrap_or_else(|| e.into()))?;
    let (width, height) = decoder.dimensions();
    check_size([u64::from(width), u64::from(height)], decoder.total_bytes())?;
    let raw = decoder.total_bytes();
    let texels = u64::from(width) * u64::from(height) * u64::from(decoder.color_type().channel_count());
    // Texels of one byte are kept as they are; others become floats.
    let kept = if raw == texels { raw } else { 4 * texels };
    memory.check(MemoryKind::Images, raw.saturating_add(kept))?;
    memory.take(MemoryKind::Images, with_levels(kept))?;
    Ok(image_of(DynamicImage::from_decoder(decoder)?, color_space))
}

/// The problem of a file whose header says that it has no pixels; decoders have many words for that.
fn empty(bytes: &[u8], format: ImageFormat) -> Option<ImageProblem> {
    let number = |at: usize| bytes.get(at..at + 4)?.try_into().ok();
    let [width, height] = match format {
        ImageFormat::Png => [16, 20].map(|at| number(at).map(u32::from_be_bytes)),
        // The height is negative where rows run from the top.
        ImageFormat::Bmp => [18, 22].map(|at| number(at).map(|b| i32::from_le_bytes(b).unsigned_abs())),
        _ => [None; 2],
    };
    let (width, height) = (u64::from(width?), u64::from(height?));
    (width == 0 || height == 0).then_some(ImageProblem::Size { width, height })
}

fn image_of(picture: DynamicImage, color_space: ColorSpace) -> Bitmap {
    use DynamicImage as D;
    let size = [picture.width(), picture.height()];
    let eight = |channels, values| {
        let storage = match color_space {
            ColorSpace::Srgb => Storage::Srgb8(values),
            ColorSpace::Raw => Storage::Linear8(values),
        };
        let ([width, height], repaired) = (size, 0);
        Bitmap {
            width,
            height,
            channels,
            storage,
            repaired,
            levels: Vec::new(),
        }
    };
    let sixteen = |channels: usize, values: &[u16]| {
        let is_color = |i: usize| channels < 4 || i % 4 < 3;
        let floats = values.iter().enumerate().map(|(i, v)| match color_space {
            ColorSpace::Srgb if is_color(i) => SRGB_16[usize::from(*v)],
            _ => f32::from(*v) / 65535.0,
        });
        Bitmap::from_floats(size, channels, floats.collect())
    };
    match picture {
        D::ImageLuma8(p) => eight(1, p.into_raw()),
        D::ImageRgb8(p) => eight(3, p.into_raw()),
        D::ImageRgba8(p) => eight(4, p.into_raw()),
        p @ D::ImageLumaA8(_) => eight(4, p.into_rgba8().into_raw()),
        D::ImageLuma16(p) => sixteen(1, p.as_raw()),
        D::ImageRgb16(p) => sixteen(3, p.as_raw()),
        D::ImageRgba16(p) => sixteen(4, p.as_raw()),
        p @ D::ImageLumaA16(_) => sixteen(4, p.into_rgba16().as_raw()),
        D::ImageRgb32F(p) => Bitmap::from_floats(size, 3, p.into_raw()),
        p => Bitmap::from_floats(size, 4, p.into_rgba32f().into_raw()),
    }
}

static SRGB_16: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..=u16::MAX).map(|v| srgb::decode(f32::from(v) / 65535.0)).collect());

/// Whether the end-of-image marker follows the segments and scans.
fn jpeg_has_an_end(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let Some(skipped) = bytes.get(at..).and_then(|rest| rest.iter().position(|b| *b == 0xff)) {
        at += skipped + 1;
        match bytes.get(at) {
            Some(0xd9) => return true,
            // An escaped 0xff of a scan, a marker without a segment, or padding.
            Some(0x00 | 0x01 | 0xd0..=0xd8) => at += 1,
            Some(0xff) => {}
            _ => match bytes.get(at + 1..at + 3) {
                Some(&[high, low]) => at += 1 + usize::from(u16::from_be_bytes([high, low])),
                _ => return false,
            },
        }
    }
    false
}

#[cfg(test)]
mod tests;
