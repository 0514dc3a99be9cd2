//! Facts that a finished file holds about itself.

use std::{
    fs::{self, File},
    io,
    path::Path,
};

use super::{Attribute, Value};
use crate::film::Window;

/// The facts that a complete file holds about itself. A file of another program has facts too, but no version.
#[derive(Clone, Debug, PartialEq)]
pub struct FileFacts {
    /// The columns and rows of the full picture; of a PNG file of another program those that it holds.
    pub resolution: [u32; 2],
    /// The part of the picture that the file holds.
    pub window: Window,
    /// In the order of the file. Attributes of types that no [`Value`] has and very long ones are left out.
    pub attributes: Vec<Attribute>,
}

/// Opens a regular file. Anything else, such as a named pipe, could block for ever and is an error.
pub(super) fn open(path: &Path) -> io::Result<File> {
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file"));
    }
    File::open(path)
}

impl FileFacts {
    /// The longest attribute that is kept, in bytes.
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

    /// The version of the renderer, if it was this one that wrote the file.
    pub fn version(&self) -> Option<&str> {
        match self.attribute("software").or_else(|| self.attribute("Software"))? {
            Value::String(text) => text.strip_prefix("batch-render "),
            _ => None,
        }
    }
}
