//! Output: finished frames, file formats, and atomic writing.
//!
//! A format is one file and one row of [`FORMATS`]; its name is the extension of its files.

pub mod atomic;
mod attribute;
mod camera_attributes;
mod counting;
pub mod display;
mod encode;
mod error;
pub mod exr;
mod facts;
mod file_names;
mod frame;
mod frame_attributes;
mod held;
pub mod job_file;
mod join;
mod jpeg_quality;
pub mod jpg;
mod metadata;
pub mod names;
pub mod npz;
pub mod png;
mod seal;
pub mod sequence;
mod tone;

use std::path::Path;

use crate::film::Film;

pub use atomic::PendingFile;
pub use attribute::{Attribute, Value};
pub use camera_attributes::camera_attributes;
pub use display::{DisplayTransform, PixelDisplay};
pub use encode::{
    BlockShape, Contents, DepthUnit, EncodeError, Encoding, Format, LightType, NpzCompression, Parts, PngBits,
    WriteReport,
};
pub use error::{Obstacle, OutputError};
pub use exr::{Compression, Exr, ExrFile, FilePart, FilePlane, Numbers};
pub use facts::{FileFacts, decoded};
pub use file_names::FileNames;
pub use frame::{Coverage, FrameImage, Shown};
pub use join::{CropFile, JoinError};
pub use jpeg_quality::JpegQuality;
pub use metadata::FrameMetadata;
pub use seal::NAME as SEAL;
pub use sequence::{FilePattern, FilePatternError};

/// Every format.
pub const FORMATS: &[&dyn Format] = &[&exr::Exr, &jpg::Jpg, &npz::Npz, &png::Png];

/// The endings of the formats whose crops can be joined, for messages: `.exr, .npz or .png`.
pub fn joined_endings() -> String {
    let formats = FORMATS.iter().filter(|format| format.can_join());
    let endings = formats.map(|format| format!(".{}", format.name()));
    let [others @ .., last] = &endings.collect::<Vec<_>>()[..] else {
        return String::new();
    };
    format!("{} or {last}", others.join(", "))
}

/// The format of this name, in any case.
pub fn format(name: &str) -> Option<&'static dyn Format> {
    FORMATS.iter().copied().find(|f| f.name().eq_ignore_ascii_case(name))
}

/// Encodes `image` with a seal, so that [`Format::inspect`] detects every change of the file.
///
/// # Errors
/// The format cannot hold such an image.
pub fn encode(
    format: &dyn Format,
    image: &FrameImage,
    encoding: Encoding,
) -> Result<(Vec<u8>, WriteReport), EncodeError> {
    let mut bytes = Vec::new();
    let report = format.encode(image, encoding, &mut bytes)?;
    seal::seal(&mut bytes);
    Ok((bytes, report))
}

/// Seals the bytes of a file, if it has a placeholder.
pub fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    seal::seal(&mut bytes);
    bytes
}

/// Writes `image` to `path` in an existing folder. On an error an old file stays unchanged.
pub fn write(
    path: &Path,
    format: &dyn Format,
    image: &FrameImage,
    encoding: Encoding,
) -> Result<WriteReport, OutputError> {
    let (file, report) = write_pending(path, format, image, encoding)?;
    atomic::put([file].into())?;
    Ok(report)
}

/// Writes `image` to a file that is to be at `path`, in an existing folder, once it is [put](atomic::put).
pub fn write_pending(
    path: &Path,
    format: &dyn Format,
    image: &FrameImage,
    encoding: Encoding,
) -> Result<(PendingFile, WriteReport), OutputError> {
    PendingFile::new(path, |out| {
        let mut out = seal::Sealing::new(out);
        let report = format.encode(image, encoding, &mut out)?;
        out.finish()?;
        Ok(report)
    })
}

/// Joins the crops of a picture of this resolution, at least one, and returns the bytes of the file. `own` are the attributes in
/// which the whole picture differs from its crops.
///
/// # Errors
/// The crops do not cover each pixel once, a file cannot be read, or the files do not fit together.
pub fn join(
    format: &dyn Format,
    resolution: [u32; 2],
    crops: &[CropFile],
    own: &[Attribute],
) -> Result<Vec<u8>, JoinError> {
    join::check_cover(resolution, crops)?;
    let mut own = own.to_vec();
    own.push(Attribute::new(seal::NAME, seal::PLACEHOLDER));
    Ok(sealed(format.join(crops, &own)?))
}

/// Writes a single film, and makes the folders of `path`; the extension selects the format.
///
/// # Errors
/// No format has this extension, or the file cannot be written.
pub fn write_still(path: &Path, film: &Film, metadata: &FrameMetadata) -> Result<WriteReport, OutputError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let format = format(extension).ok_or_else(|| OutputError::Encode {
        reason: format!("no format is called '{extension}'"),
        path: path.to_owned(),
    })?;
    atomic::check(path)?;
    let image = FrameImage {
        film,
        shown: Shown::All,
        coverage: Coverage::Partial,
        metadata,
    };
    write(path, format, &image, Encoding::default())
}

#[cfg(test)]
mod tests;
