//! The headers of a file: what its attributes say, and where its blocks begin.

use std::io::{self, BufRead, Read, Seek};

use super::header::{self, LONG_NAMES, MAGIC, MULTI_PART, VERSION};
use crate::{
    film::Window,
    output::{Attribute, Value},
};

/// The headers of a scanline file.
pub(super) struct Headers {
    pub is_multi: bool,
    /// At least one.
    pub parts: Vec<Header>,
}

/// The header of a part.
pub(super) struct Header {
    /// The compression as files number it.
    pub compression: u8,
    lines_per_block: u64,
    pub display: Window,
    pub data: Window,
    /// In the order of the file.
    pub attributes: Vec<Attribute>,
}

impl Header {
    /// The number of its blocks.
    pub fn blocks(&self) -> u64 {
        u64::from(self.data.height()).div_ceil(self.lines_per_block)
    }
}

impl Headers {
    /// Reads the headers; `file` stands behind them afterwards. Attributes of types that no [`Value`] has are left out, and so are
    /// those of more than `max_attribute` bytes. `None` of any other file.
    ///
    /// # Errors
    /// The file cannot be read, or ends.
    pub fn read(file: &mut (impl BufRead + Seek), max_attribute: usize) -> io::Result<Option<Self>> {
        let magic: [u8; 4] = take(file)?;
        let flags = u32::from_le_bytes(take(file)?) & !LONG_NAMES;
        // Any other flag: tiles or deep data.
        if magic != MAGIC || flags & !MULTI_PART != VERSION {
            return Ok(None);
        }
        let is_multi = flags & MULTI_PART != 0;
        let mut parts = Vec::new();
        while parts.is_empty() || is_multi {
            match read_header(file, max_attribute)? {
                HeaderRead::Part(part) => parts.push(part),
                HeaderRead::End if !parts.is_empty() => break,
                HeaderRead::End | HeaderRead::Unfit => return Ok(None),
            }
        }
        Ok(Some(Self { is_multi, parts }))
    }
}

enum HeaderRead {
    Part(Header),
    /// No attribute: the end of the headers.
    End,
    /// Attributes are missing, or the compression is unknown.
    Unfit,
}

fn read_header(file: &mut (impl BufRead + Seek), max_attribute: usize) -> io::Result<HeaderRead> {
    let (mut compression, mut attributes, mut is_empty) = (None, Vec::new(), true);
    loop {
        let name = name(file)?;
        if name.is_empty() {
            break;
        }
        is_empty = false;
        let kind = self::name(file)?;
        let size = u32::from_le_bytes(take(file)?);
        if name == b"compression" && size == 1 {
            compression = Some(take::<1>(file)?[0]);
        } else if size as usize <= max_attribute {
            let mut bytes = vec![0; size as usize];
            file.read_exact(&mut bytes)?;
            if let (Ok(name), Some(value)) = (String::from_utf8(name), header::decode(&kind, &bytes)) {
                attributes.push(Attribute { name, value });
            }
        } else {
            file.seek_relative(i64::from(size))?;
        }
    }
    let window = |name: &str| {
        attributes.iter().find_map(|a| match a.value {
            Value::Box2i(window) if a.name == name => Some(window),
            _ => None,
        })
    };
    let compression = compression.and_then(|code| Some((code, lines_per_block(code)?)));
    Ok(match (compression, window("dataWindow"), window("displayWindow")) {
        _ if is_empty => HeaderRead::End,
        (Some((compression, lines_per_block)), Some(data), Some(display)) => HeaderRead::Part(Header {
            compression,
            lines_per_block,
            display,
            data,
            attributes,
        }),
        _ => HeaderRead::Unfit,
    })
}

fn lines_per_block(compression: u8) -> Option<u64> {
    match compression {
        0..=2 => Some(1),          // none, rle, zips
        3 | 5 => Some(16),         // zip, pxr24
        4 | 6 | 7 | 8 => Some(32), // piz, b44, b44a, dwaa
        9 => Some(256),            // dwab
        _ => None,
    }
}

/// A name without its final 0; names have at most 255 bytes.
fn name(file: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut name = Vec::new();
    file.take(256).read_until(0, &mut name)?;
    match name.pop() {
        Some(0) => Ok(name),
        _ => Err(io::ErrorKind::UnexpectedEof.into()),
    }
}

pub(super) fn take<const N: usize>(file: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}
