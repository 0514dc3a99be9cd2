//! Film to files: what a finished frame is, the formats that hold it, and writing them so that a file is whole or absent.
//!
//! A format is one file and one row of [`FORMATS`]; its name is the extension of its files.

pub mod atomic;
mod attribute;
pub mod exr;
mod facts;
pub mod png;
pub mod sequence;

use std::{
    fmt::Debug,
    io::{self, Write},
    path::{Path, PathBuf},
};

use crate::film::{self, Film, view::View};

pub use attribute::{Attribute, Value};
pub use exr::{Channel, Compression, Plane, Samples};
pub use facts::FileFacts;
pub use sequence::{Pattern, PatternError};

/// A rectangle of pixels; x to the right, y down, the origin is the top left pixel of the full frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The leftmost column; negative with overscan.
    pub x: i32,
    /// The top row; negative with overscan.
    pub y: i32,
    pub width: u32,
    pub height: u32,
}

impl Window {
    /// The window of a whole frame.
    pub const fn full(width: u32, height: u32) -> Self {
        let (x, y) = (0, 0);
        Self { x, y, width, height }
    }

    /// How many pixels it holds.
    pub const fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }
}

impl From<film::Window> for Window {
    /// Films are of fewer than 2^31 columns and rows.
    fn from(w: film::Window) -> Self {
        Self {
            x: w.x0 as i32,
            y: w.y0 as i32,
            width: w.width(),
            height: w.height(),
        }
    }
}

/// A finished frame, as every format receives it.
#[derive(Clone, Copy, Debug)]
pub struct FrameImage<'a> {
    /// The full frame, in pixels.
    pub resolution: [u32; 2],
    /// What of it was rendered: the frame, a crop, or more with overscan.
    pub window: Window,
    /// The beauty in `window`, the top row first: scene-linear RGB, premultiplied, and alpha.
    pub rgba: &'a [[f32; 4]],
    /// Whether its alpha says anything.
    pub coverage: Coverage,
    /// More channels over `window`, for the formats that hold them.
    pub layers: &'a [Channel<'a>],
    /// What the readers of `layers` need to know, written with them.
    pub layer_attributes: &'a [Attribute],
    /// The number of the frame.
    pub frame: i32,
    /// Samples of each pixel.
    pub samples: u32,
    pub seed: u64,
    /// Where the random numbers come from.
    pub sampler: &'a str,
    /// How 8-bit formats show the light.
    pub view: View,
    /// Stops, for 8-bit formats.
    pub exposure: f32,
    /// Frames per second as a fraction, where the job knows it.
    pub fps: Option<(i32, u32)>,
    /// What else files should say. A name that the renderer writes itself is replaced.
    pub metadata: &'a [Attribute],
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

/// How the beauty is stored where a format has a choice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    #[default]
    Half,
    Float,
}

/// What the user chose about encoding.
#[derive(Clone, Copy, Debug, Default)]
pub struct Encoding {
    pub compression: Compression,
    pub depth: Depth,
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

/// Writes one picture that belongs to no sequence; the name's ending chooses the format.
pub fn picture(path: &Path, film: &Film, view: View) -> Result<WriteReport, OutputError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let format = format(extension).ok_or_else(|| OutputError::Encode {
        reason: format!("no format is called '{extension}'"),
        path: path.to_owned(),
    })?;
    let image = FrameImage {
        resolution: film.resolution,
        window: film.window.into(),
        rgba: &film.pixels,
        coverage: Coverage::Partial,
        layers: &[],
        layer_attributes: &[],
        frame: 1,
        samples: 1,
        seed: 0,
        sampler: "sobol",
        view,
        exposure: 0.0,
        fps: None,
        metadata: &[],
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
