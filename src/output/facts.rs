//! The facts in the header of a complete file.

use std::{
    fs::{self, File},
    io::{self, Cursor},
    path::Path,
};

use image::{DynamicImage, ImageReader};

use super::{Attribute, Value};
use crate::film::Window;

/// The facts in the header of a complete file. A file of another program has no version.
#[derive(Clone, Debug, PartialEq)]
pub struct FileFacts {
    /// The columns and rows of the full picture; those of the file where another program wrote it.
    pub resolution: [u32; 2],
    /// The part of the picture in the file.
    pub window: Window,
    /// In the order of the file, without very long attributes and those of types without a [`Value`].
    pub attributes: Vec<Attribute>,
}

/// Opens a regular file. Anything else is an error; a named pipe could block forever.
pub(super) fn open(path: &Path) -> io::Result<File> {
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file"));
    }
    File::open(path)
}

impl FileFacts {
    /// The limit of an attribute's length, in bytes.
    pub(super) const MAX_ATTRIBUTE: usize = 1 << 16;

    pub fn attribute(&self, name: &str) -> Option<&Value> {
        self.attributes.iter().find(|a| a.name == name).map(|a| &a.value)
    }

    /// The number of the frame.
    pub fn frame(&self) -> Option<i32> {
        match self
            .attribute("batch-render/frame")
            .or_else(|| self.attribute("Frame"))?
        {
            Value::Int(frame) => Some(*frame),
            Value::String(text) => text.parse().ok(),
            _ => None,
        }
    }

    /// The version of this renderer, if it wrote the file.
    pub fn version(&self) -> Option<&str> {
        match self.attribute("software").or_else(|| self.attribute("Software"))? {
            Value::String(text) => text.strip_prefix("batch-render "),
            _ => None,
        }
    }
}

/// The picture of a finished file, in one of the formats of the crate `image`; `None` if it is not readable.
pub fn decoded(path: &Path) -> Option<DynamicImage> {
    let bytes = fs::read(path).ok()?;
    let format = image::guess_format(&bytes).ok()?;
    // The same reader as that of textures, so that the decoders are compiled once.
    ImageReader::with_format(Cursor::new(&bytes[..]), format).decode().ok()
}
