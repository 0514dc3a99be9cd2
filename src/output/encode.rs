//! The contract of output formats, with the inputs and results of encoding.

use std::{
    fmt::Debug,
    io::{self, Write},
    path::Path,
};

use serde::Serialize;

use super::{
    Attribute, Compression, FileFacts, FrameImage, JpegQuality,
    join::{CropFile, JoinError},
};
use crate::kind::named;

/// The user's choices about encoding.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Encoding {
    /// The compression of EXR files. The next three fields are for EXR files, too.
    pub compression: Compression,
    pub light: LightType,
    pub parts: Parts,
    pub blocks: BlockShape,
    pub png: PngBits,
    /// Not part of the fingerprint of files of the default quality.
    #[serde(skip_serializing_if = "JpegQuality::is_default")]
    pub jpeg: JpegQuality,
    /// Not part of the fingerprint of files that are not compressed.
    #[serde(skip_serializing_if = "NpzCompression::is_default")]
    pub npz: NpzCompression,
    /// Not part of the fingerprint of files in millimetres.
    #[serde(skip_serializing_if = "DepthUnit::is_default")]
    pub depth: DepthUnit,
}

named! {
    /// The bits of each number of PNG files.
    #[derive(Default)]
    pub enum PngBits: "bits" {
        #[default]
        Eight = "8",
        /// Eight, dithered, so that smooth shades have no steps.
        Dithered = "8-dithered",
        Sixteen = "16",
    }
}

named! {
    /// The type of the numbers of light, and of normals, in EXR files.
    #[derive(Default)]
    pub enum LightType: "type" {
        /// 16 bits.
        #[default]
        Half = "half",
        /// 32 bits.
        Float = "float",
    }
}

named! {
    /// The unit of the whole numbers in PNG files of depth.
    #[derive(Default)]
    pub enum DepthUnit: "unit" {
        #[default]
        Millimetre = "mm",
        Centimetre = "cm",
        Metre = "m",
    }
}

named! {
    /// A compression method of NPZ files. Both are lossless.
    #[derive(Default)]
    pub enum NpzCompression: "compression" {
        /// Arrays are stored as they are in memory, which programs may map.
        #[default]
        None = "none",
        Deflate = "deflate",
    }
}

impl NpzCompression {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

impl DepthUnit {
    /// The number of units in a metre.
    pub fn per_metre(self) -> f32 {
        match self {
            Self::Millimetre => 1000.0,
            Self::Centimetre => 100.0,
            Self::Metre => 1.0,
        }
    }

    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// The parts of an EXR file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Parts {
    /// One part with all layers.
    #[default]
    One,
    /// A part for each layer.
    Many,
}

/// The shape of the blocks of an EXR file, each of which is compressed separately.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum BlockShape {
    /// Whole lines; the compression determines their number.
    #[default]
    Lines,
    /// Squares, for programs that read parts of large pictures.
    Tiles,
}

/// The result of writing a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteReport {
    /// The size of the file.
    pub bytes: u64,
    /// Numbers beyond the range of halves, which became +-65504.
    pub clamped: u64,
    /// NaNs, which became 0.
    pub nans: u64,
    /// Depths beyond the range of a PNG file, which became 65535.
    pub saturated: u64,
}

/// A kind of picture file.
pub trait Format: Debug + Sync {
    /// The name of the format; also the extension of its files.
    fn name(&self) -> &'static str;

    /// The contents of the files.
    fn contents(&self) -> Contents;

    /// Whether files may follow each other in one stream: a reader finds the end of each.
    fn makes_streams(&self) -> bool {
        true
    }

    /// Writes `image` to `out`. The same image and encoding give the same bytes.
    fn encode(&self, image: &FrameImage, encoding: Encoding, out: &mut dyn Write) -> Result<WriteReport, EncodeError>;

    /// The most columns and rows of a file.
    fn largest_side(&self) -> u32 {
        u32::MAX
    }

    /// Whether crops can be joined, because the numbers in files come back as they were.
    fn can_join(&self) -> bool {
        true
    }

    /// Whether files of this encoding do not keep the numbers of passes of data.
    fn loses_data(&self, encoding: Encoding) -> bool {
        let _ = encoding;
        false
    }

    /// Returns the facts in the header of the file at `path`, whatever its pixels; `None` if it cannot be read, is of another
    /// format or cut off.
    fn facts(&self, path: &Path) -> Option<FileFacts>;

    /// Returns the facts of the file at `path`; `None` if it cannot be read, is of another format, incomplete or altered.
    fn inspect(&self, path: &Path) -> Option<FileFacts>;

    /// Joins crops, of which there is at least one and which cover each pixel once, and returns the bytes of the file of the whole
    /// picture. `own` replaces the attributes of the same names.
    ///
    /// # Errors
    /// A file cannot be read, or the files do not fit together.
    fn join(&self, crops: &[CropFile], own: &[Attribute]) -> Result<Vec<u8>, JoinError>;
}

/// The part of a frame that a format keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contents {
    /// Scene-linear light and all layers.
    Data,
    /// Display values of the beauty.
    Picture,
    /// One pass as numbers.
    Pass,
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

impl From<png::EncodingError> for EncodeError {
    fn from(error: png::EncodingError) -> Self {
        match error {
            png::EncodingError::IoError(source) => Self::Io(source),
            other => Self::Unfit(other.to_string()),
        }
    }
}
