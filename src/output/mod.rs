//! Film to files: what a finished frame is, the formats that hold it, and writing them so that a file is whole or absent.
//!
//! A format is one file and one row of [`FORMATS`]; its name is the extension of its files.

pub mod atomic;
mod attribute;
pub mod display;
pub mod exr;
mod facts;
mod metadata;
pub mod png;
pub mod sequence;

use std::{
    fmt::Debug,
    io::{self, Write},
    path::{Path, PathBuf},
};

use crate::film::{Film, Plane};

pub use attribute::{Attribute, Value};
pub use display::DisplayTransform;
pub use exr::Compression;
pub use facts::FileFacts;
pub use metadata::FrameMetadata;
pub use sequence::{Pattern, PatternError};

/// A finished frame, as every format receives it.
#[derive(Clone, Copy, Debug)]
pub struct FrameImage<'a> {
    pub film: &'a Film,
    pub shown: Shown,
    /// Whether its alpha says anything.
    pub coverage: Coverage,
    pub metadata: &'a FrameMetadata,
}

/// The planes of a film that go into its files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shown {
    /// All of them; formats for displays show the first, which the integrator computed.
    #[default]
    All,
    /// The one with this index, in place of the picture.
    Plane(usize),
}

impl<'a> FrameImage<'a> {
    /// The plane that formats for displays show.
    pub fn picture(&self) -> &'a Plane {
        match self.shown {
            Shown::All => &self.film.planes()[0],
            Shown::Plane(plane) => &self.film.planes()[plane],
        }
    }

    /// Whether a plane that goes into files holds light.
    fn has_light(&self) -> bool {
        match self.shown {
            Shown::All => self.film.planes().iter().any(|plane| plane.spec.pass.is_light()),
            Shown::Plane(_) => self.picture().spec.pass.is_light(),
        }
    }
}

/// Whether the alpha of a picture says anything. It belongs to the job and not to the frame's pixels, so that all files of a
/// sequence have the same channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coverage {
    /// A visible background: alpha is 1 everywhere, and formats for displays leave it out.
    Full,
    /// Pixels may be empty.
    Partial,
}

/// The user's choices about encoding.
#[derive(Clone, Copy, Debug, Default)]
pub struct Encoding {
    pub compression: Compression,
}

/// What was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteReport {
    /// The size of the file.
    pub bytes: u64,
    /// Numbers beyond what a half holds that became +-65504.
    pub clamped: u64,
    /// Numbers that were not a number and became 0.
    pub nans: u64,
}

/// A kind of picture file.
pub trait Format: Debug + Sync {
    /// What it is called; also the extension of its files.
    fn name(&self) -> &'static str;

    /// Whether it holds every layer and the light itself, or only a picture for a display.
    fn contents(&self) -> Contents;

    /// Writes `image` to `out`: the same bytes for the same image and encoding.
    fn encode(&self, image: &FrameImage, encoding: Encoding, out: &mut dyn Write) -> Result<WriteReport, EncodeError>;

    /// Returns what the file at `path` says about itself; `None` where it cannot be read, is not of this format, or is not
    /// complete to its last byte.
    fn inspect(&self, path: &Path) -> Option<FileFacts>;
}

/// What a format keeps of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contents {
    /// Scene-linear light and all layers.
    Data,
    /// Display values of the beauty.
    Picture,
}

/// Every format.
pub const FORMATS: &[&dyn Format] = &[&exr::Exr, &png::Png];

/// The format of this name, in any case.
pub fn format(name: &str) -> Option<&'static dyn Format> {
    FORMATS.iter().copied().find(|f| f.name().eq_ignore_ascii_case(name))
}

/// Writes `image` to `path`, which is afterwards the whole file or, on an error, what it was before.
pub fn write(
    path: &Path,
    format: &dyn Format,
    image: &FrameImage,
    encoding: Encoding,
) -> Result<WriteReport, OutputError> {
    atomic::write(path, |out| format.encode(image, encoding, out))
}

/// Writes a film that belongs to no sequence; the name's ending chooses the format.
///
/// # Errors
/// No format has this ending, or the file cannot be written.
pub fn write_still(path: &Path, film: &Film, metadata: &FrameMetadata) -> Result<WriteReport, OutputError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let format = format(extension).ok_or_else(|| OutputError::Encode {
        reason: format!("no format is called '{extension}'"),
        path: path.to_owned(),
    })?;
    let image = FrameImage {
        film,
        shown: Shown::All,
        coverage: Coverage::Partial,
        metadata,
    };
    write(path, format, &image, Encoding::default())
}

/// Why a file was not written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// Nothing can be made at this place.
    #[error("cannot create output: {source}: {}", path.display())]
    Create { source: io::Error, path: PathBuf },
    /// Writing began and failed.
    #[error("cannot write output: {source}: {}", path.display())]
    Write { source: io::Error, path: PathBuf },
    /// The format cannot hold such an image.
    #[error("cannot encode output: {reason}: {}", path.display())]
    Encode { reason: String, path: PathBuf },
}

impl OutputError {
    /// Whether the disk itself is at fault (full, read-only), so that no other frame will fare better.
    pub fn ends_the_job(&self) -> bool {
        use io::ErrorKind::{QuotaExceeded, ReadOnlyFilesystem, StorageFull};
        match self {
            Self::Create { source, .. } | Self::Write { source, .. } => {
                matches!(source.kind(), StorageFull | QuotaExceeded | ReadOnlyFilesystem)
            }
            Self::Encode { .. } => false,
        }
    }
}

/// Why encoding stopped.
#[derive(Debug, thiserror::Error)]
pub enum EncodeError {
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The format cannot hold such an image.
    #[error("{0}")]
    Unfit(String),
}

/// Passes bytes on and counts them.
struct Counting<'a> {
    out: &'a mut dyn Write,
    bytes: u64,
}

impl Write for Counting<'_> {
    fn write(&mut self, buf: &[u8]) -> io::Result<usize> {
        let n = self.out.write(buf)?;
        self.bytes += n as u64;
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests;
