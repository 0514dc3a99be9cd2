//! Images: PNG, JPEG, BMP, TGA, WebP, HDR and EXR files.
//!
//! The content determines the format, or the extension for formats without a signature (TGA). Row 0 is the top row; Exif
//! orientations are ignored. The caller decides whether integer formats are display values or data; HDR and EXR are always
//! scene-linear, and colours of EXR are premultiplied. Texels of 8 and 16 bits are kept and converted by a
//! table; deeper ones become floats.
//!
//! A truncated or damaged file, or one that claims an absurd size, is an error, never a partial picture.

mod error;
mod exr;
mod limits;
mod png_numbers;
mod texture_memory;

use std::{
    io::Cursor,
    path::{Path, PathBuf},
    sync::Arc,
};

use super::{Files, MemoryBudget, MemoryKind, files::ContentHash, model::ImageSource};
use crate::texture::{
    bitmap::{Bitmap, ColorSpace, Storage},
    mipmap,
};
use ::image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use error::ImageProblem;
use limits::{MAX_BYTES, MAX_SIDE, check_size, shrunk, with_levels};

pub use error::ImageError;
pub use exr::{
    PictureWindow,
    passes::{ImagePass, PassChannel},
};
pub use png_numbers::PngNumbers;
pub use texture_memory::halvings;

/// The first bytes of a JPEG file.
const JPEG_MAGIC: [u8; 3] = [0xff, 0xd8, 0xff];

/// The most texels along a side that are examined to classify a picture.
const PROBES: u32 = 64;

/// The alpha of a picture of colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AlphaUse {
    /// Alpha and colours are apart: colours that a file has multiplied by alpha are divided by it.
    #[default]
    Straight,
    /// The same, and alpha is the opacity of the colours.
    Opacity,
    /// Alpha is not used: colours stay as they are in the file.
    Unused,
}

/// An image, and how to read its numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageRequest {
    pub source: ImageSource,
    pub color_space: ColorSpace,
    pub alpha: AlphaUse,
}

impl ImageRequest {
    pub fn new(source: ImageSource, color_space: ColorSpace) -> Self {
        Self {
            source,
            color_space,
            alpha: AlphaUse::default(),
        }
    }
}

/// The content of a bitmap: that of an image with this content, halved so many times.
#[derive(Clone, Debug, PartialEq)]
pub struct BitmapKey {
    request: ImageRequest,
    /// The content of the file; `None` for one that is part of another file.
    file: Option<ContentHash>,
    halvings: u32,
}

impl BitmapKey {
    /// The key of an image that was read by way of `files`; `None` if that has not read it.
    pub fn new(request: &ImageRequest, halvings: u32, files: &Files) -> Option<Self> {
        let file = match &request.source {
            ImageSource::Bytes { .. } => None,
            ImageSource::File(path) => Some(files.hash(path)?),
        };
        let request = request.clone();
        Some(Self {
            request,
            file,
            halvings,
        })
    }
}

/// An image that is not decoded yet.
pub struct EncodedImage {
    bytes: Arc<[u8]>,
    /// The name in errors; its extension tells the format if the bytes do not.
    path: PathBuf,
    color_space: ColorSpace,
    alpha: AlphaUse,
}

/// All passes of an EXR file, by their names; `None` of a picture of another format.
///
/// # Errors
/// The file cannot be read, or it is broken.
pub fn passes(path: &Path, files: &Files) -> Result<Option<Vec<ImagePass>>, ImageError> {
    let request = ImageRequest::new(ImageSource::File(path.to_owned()), ColorSpace::Raw);
    let EncodedImage { bytes, .. } = EncodedImage::read(&request, files)?;
    let is_exr = bytes.starts_with(&exr::MAGIC);
    let passes = is_exr.then(|| exr::passes(&bytes, files.memory())).transpose();
    passes.map_err(|problem| problem.at(path))
}

impl EncodedImage {
    /// Reads the bytes of an image.
    pub fn read(request: &ImageRequest, files: &Files) -> Result<Self, ImageError> {
        let (bytes, path) = match &request.source {
            ImageSource::Bytes { name, bytes } => (Arc::clone(bytes), name),
            ImageSource::File(path) => {
                let bytes = files.read(path).map_err(|source| ImageError::Read {
                    source,
                    path: path.to_owned(),
                })?;
                (bytes, path)
            }
        };
        Ok(Self {
            bytes,
            path: path.to_owned(),
            color_space: request.color_space,
            alpha: request.alpha,
        })
    }

    /// The bytes of memory for all levels after some halvings, by the header; 0 if that is broken.
    pub fn memory(&self, halvings: u32) -> u64 {
        let memory = if self.bytes.starts_with(&exr::MAGIC) {
            exr::memory(&self.bytes, halvings).ok()
        } else {
            self.opened()
                .ok()
                .map(|decoder| Sizes::of(&decoder).in_memory(halvings))
        };
        memory.unwrap_or(0)
    }

    /// Counts the memory of its bitmap, which is there already.
    pub fn count(&self, halvings: u32, memory: &MemoryBudget) -> Result<(), ImageError> {
        let counted = memory.take(MemoryKind::Images, self.memory(halvings));
        counted.map_err(|cause| ImageProblem::from(cause).at(&self.path))
    }

    /// Checks the memory of its bitmap and of decoding it.
    pub fn check(&self, memory: &MemoryBudget) -> Result<(), ImageError> {
        let checked = memory.check(MemoryKind::Images, self.memory(0).saturating_mul(2));
        checked.map_err(|cause| ImageProblem::from(cause).at(&self.path))
    }

    /// Decodes it and halves its size `halvings` times.
    pub fn decode(&self, halvings: u32, memory: &MemoryBudget) -> Result<Bitmap, ImageError> {
        let decoded = if self.bytes.starts_with(&exr::MAGIC) {
            let is_color = self.color_space == ColorSpace::Srgb && self.alpha != AlphaUse::Unused;
            exr::decode(&self.bytes, halvings, memory)
                .map(|picture| if is_color { straightened(picture) } else { picture })
        } else {
            self.decode_by_format(halvings, memory)
        };
        let mut bitmap = decoded.map_err(|problem| problem.at(&self.path))?;
        bitmap.weighs_by_alpha = self.alpha == AlphaUse::Opacity && bitmap.has_alpha();
        Ok(mipmap::halved(bitmap, halvings))
    }

    /// Decodes it without halving it; an EXR file over its data window.
    pub fn decode_data(&self, memory: &MemoryBudget) -> Result<(Bitmap, PictureWindow), ImageError> {
        if self.bytes.starts_with(&exr::MAGIC) {
            return exr::decode_data(&self.bytes, memory).map_err(|problem| problem.at(&self.path));
        }
        let bitmap = self.decode(0, memory)?;
        let window = PictureWindow {
            first: [0; 2],
            display: [bitmap.width, bitmap.height],
        };
        Ok((bitmap, window))
    }

    /// The meaning of its numbers, if it is a PNG file of data.
    pub fn png_numbers(&self) -> Option<PngNumbers> {
        PngNumbers::of(&self.bytes)
    }

    /// Opens the decoder, which reads the header.
    fn opened(&self) -> Result<impl ImageDecoder, ImageProblem> {
        let (bytes, path) = (&self.bytes[..], &self.path);
        let format = ::image::guess_format(bytes).or_else(|_| ImageFormat::from_path(path));
        let format = format
            .ok()
            .filter(ImageFormat::reading_enabled)
            .ok_or(ImageProblem::Unknown)?;
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_SIDE);
        limits.max_image_height = Some(MAX_SIDE);
        limits.max_alloc = Some(MAX_BYTES);
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        reader.limits(limits);
        reader
            .into_decoder()
            .map_err(|e| empty(bytes, format).unwrap_or_else(|| e.into()))
    }

    fn decode_by_format(&self, halvings: u32, memory: &MemoryBudget) -> Result<Bitmap, ImageProblem> {
        if self.bytes.starts_with(&JPEG_MAGIC) && !jpeg_has_an_end(&self.bytes) {
            // The decoder would fill the rest with gray.
            return Err(ImageProblem::broken("unexpected end of file"));
        }
        let decoder = self.opened()?;
        let (width, height) = decoder.dimensions();
        let sizes = Sizes::of(&decoder);
        check_size([u64::from(width), u64::from(height)], sizes.raw)?;
        memory.check(MemoryKind::Images, sizes.raw.saturating_add(sizes.kept))?;
        memory.take(MemoryKind::Images, sizes.in_memory(halvings))?;
        Ok(image_of(DynamicImage::from_decoder(decoder)?, self.color_space))
    }
}

/// The sizes of a picture, in bytes.
struct Sizes {
    /// The size in the decoder's format.
    raw: u64,
    /// The size in memory afterwards.
    kept: u64,
    /// The size of a number.
    number: u64,
}

impl Sizes {
    fn of(decoder: &impl ImageDecoder) -> Self {
        let raw = decoder.total_bytes();
        // Gray with alpha becomes RGBA.
        let color = decoder.color_type();
        let grows = if color.channel_count() == 2 { 2 } else { 1 };
        Self {
            raw,
            kept: raw.saturating_mul(grows),
            number: u64::from(color.bytes_per_pixel() / color.channel_count()),
        }
    }

    /// The size in memory with all levels, after some halvings.
    fn in_memory(&self, halvings: u32) -> u64 {
        with_levels(shrunk(self.kept, halvings), self.number)
    }
}

/// Endings of the formats that are read.
const READ: [&str; 8] = ["png", "jpg", "jpeg", "bmp", "tga", "webp", "hdr", "exr"];

/// Whether the name has the ending of a format that is read.
pub fn has_a_picture_ending(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    READ.contains(&ending.as_str())
}

/// Whether the file at `path` is there and of a format that is not read, such as TIFF.
pub fn is_unknown(path: &Path, files: &Files) -> bool {
    if has_a_picture_ending(path) {
        return false;
    }
    let image = EncodedImage::read(
        &ImageRequest::new(ImageSource::File(path.to_owned()), ColorSpace::Raw),
        files,
    );
    image.is_ok_and(|i| !i.bytes.starts_with(&exr::MAGIC) && matches!(i.opened(), Err(ImageProblem::Unknown)))
}

/// Whether the picture at `path` has an alpha channel, by its header. False for unreadable files and for EXR.
pub fn has_alpha(path: &Path, files: &Files) -> bool {
    let Ok(bytes) = files.read(path) else { return false };
    let format = ::image::guess_format(&bytes).or_else(|_| ImageFormat::from_path(path));
    let decoder = format.map(|f| ImageReader::with_format(Cursor::new(&bytes[..]), f).into_decoder());
    matches!(decoder, Ok(Ok(decoder)) if decoder.color_type().has_alpha())
}

/// Whether the picture at `path` is a tangent-space normal map: its texels encode unit vectors that point outwards. False for
/// gray, unreadable and too large pictures.
pub fn holds_normals(path: &Path, files: &Files) -> bool {
    let request = ImageRequest::new(ImageSource::File(path.to_owned()), ColorSpace::Raw);
    let Ok(image) = EncodedImage::read(&request, files) else {
        return false;
    };
    // The header is enough for most bump maps, which are gray.
    if image.opened().is_ok_and(|decoder| !decoder.color_type().has_color()) {
        return false;
    }
    // The picture is dropped afterwards, so its memory is only checked.
    let needed = image.memory(0).saturating_mul(2);
    if files.memory().check(MemoryKind::Images, needed).is_err() {
        return false;
    }
    let Ok(picture) = image.decode(0, &MemoryBudget::default()) else {
        return false;
    };
    let (columns, rows) = (picture.width.min(PROBES), picture.height.min(PROBES));
    let place = |k: u32, n: u32, size: u32| ((2 * u64::from(k) + 1) * u64::from(size) / (2 * u64::from(n))) as u32;
    let texels = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    let is_normal = |(i, j)| {
        let texel = picture.texel_from_bottom(place(i, columns, picture.width), place(j, rows, picture.height));
        let [x, y, z] = [texel.r, texel.g, texel.b].map(|v| 2.0 * v - 1.0);
        z > 0.0 && (x * x + y * y + z * z - 1.0).abs() < 0.25 && texel.b > texel.r.max(texel.g) - 0.02
    };
    let normals = texels.filter(|at| is_normal(*at)).count();
    normals as f32 > 0.9 * (columns * rows) as f32
}

/// The problem of a file whose header says that it has no pixels. Decoders report it in different ways.
fn empty(bytes: &[u8], format: ImageFormat) -> Option<ImageProblem> {
    let number = |at: usize| bytes.get(at..at + 4)?.try_into().ok();
    let [width, height] = match format {
        ImageFormat::Png => [16, 20].map(|at| number(at).map(u32::from_be_bytes)),
        // The height is negative for rows from the top down.
        ImageFormat::Bmp => [18, 22].map(|at| number(at).map(|b| i32::from_le_bytes(b).unsigned_abs())),
        _ => [None; 2],
    };
    let (width, height) = (u64::from(width?), u64::from(height?));
    (width == 0 || height == 0).then_some(ImageProblem::Size { width, height })
}

fn image_of(picture: DynamicImage, color_space: ColorSpace) -> Bitmap {
    use DynamicImage as D;
    let size = [picture.width(), picture.height()];
    let of = |channels, storage| Bitmap::new(size, channels, storage);
    let eight = |channels, values| {
        let storage = match color_space {
            ColorSpace::Srgb => Storage::Srgb8(values),
            ColorSpace::Raw => Storage::Linear8(values),
        };
        of(channels, storage)
    };
    let sixteen = |channels, values| {
        let storage = match color_space {
            ColorSpace::Srgb => Storage::Srgb16(values),
            ColorSpace::Raw => Storage::Linear16(values),
        };
        of(channels, storage)
    };
    match picture {
        D::ImageLuma8(p) => eight(1, p.into_raw()),
        D::ImageRgb8(p) => eight(3, p.into_raw()),
        D::ImageRgba8(p) => eight(4, p.into_raw()),
        p @ D::ImageLumaA8(_) => eight(4, p.into_rgba8().into_raw()),
        D::ImageLuma16(p) => sixteen(1, p.into_raw()),
        D::ImageRgb16(p) => sixteen(3, p.into_raw()),
        D::ImageRgba16(p) => sixteen(4, p.into_raw()),
        p @ D::ImageLumaA16(_) => sixteen(4, p.into_rgba16().into_raw()),
        D::ImageRgb32F(p) => Bitmap::from_floats(size, 3, p.into_raw()),
        p => Bitmap::from_floats(size, 4, p.into_rgba32f().into_raw()),
    }
}

/// The picture whose colours were multiplied by alpha; where that is 0, they stay what they are.
fn straightened(mut picture: Bitmap) -> Bitmap {
    if let (4, Storage::Float(values)) = (picture.channels, &mut picture.storage) {
        for texel in values
            .chunks_exact_mut(4)
            .filter(|texel| texel[3] > 0.0 && texel[3] != 1.0)
        {
            let alpha = texel[3];
            texel[..3].iter_mut().for_each(|v| *v /= alpha);
        }
    }
    picture
}

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
