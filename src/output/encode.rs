//! The contract of output formats, with the inputs and results of encoding.

use std::{
    fmt::Debug,
    io::{self, Write},
    path::Path,
};

use super::{
    Attribute, Compression, FileFacts, FrameImage,
    join::{CropFile, JoinError},
};
use crate::kind::named;

/// The user's choices about encoding.
#[derive(Clone, Copy, Debug, Default)]
pub struct Encoding {
    /// The compression of EXR files; the next three are theirs, too.
    pub compression: Compression,
    pub light: LightType,
    pub parts: Parts,
    pub blocks: BlockShape,
    pub png: PngBits,
}

named! {
    /// The bits of each number of PNG files.
    #[derive(Default)]
    pub enum PngBits: "bits" {
        #[default]
        Eight = "8",
        /// Eight, rounded up or down at random, so that smooth shades have no steps.
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

/// The parts of an EXR file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parts {
    /// All layers in one.
    #[default]
    One,
    /// One for each layer.
    Many,
}

/// The shape of the blocks of an EXR file, which are compressed one by one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BlockShape {
    /// Whole lines, as many as the compression takes together.
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
    /// Numbers beyond what a half holds that became +-65504.
    pub clamped: u64,
    /// Numbers that were not a number and became 0.
    pub nans: u64,
}

/// A kind of picture file.
pub trait Format: Debug + Sync {
    /// The name of the format; also the extension of its files.
    fn name(&self) -> &'static str;

    /// Whether it holds every layer and the light itself, or only a picture for a display.
    fn contents(&self) -> Contents;

    /// Writes `image` to `out`: the same bytes for the same image and encoding.
    fn encode(&self, image: &FrameImage, encoding: Encoding, out: &mut dyn Write) -> Result<WriteReport, EncodeError>;

    /// Returns what the file at `path` says about itself; `None` where it cannot be read, is not of this format, or is not
    /// complete and unaltered to its last byte.
    fn inspect(&self, path: &Path) -> Option<FileFacts>;

    /// Returns the bytes of the file of the whole picture, whose pixels `crops` hold, each once; there is at least one. Attributes
    /// of the names in `own` get these values.
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
