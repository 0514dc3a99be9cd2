//! The headers of a file: its attributes, and the offsets of its blocks.

use std::io::{self, BufRead, Read, Seek};

use super::header::{self, LONG_NAMES, MAGIC, MULTI_PART, TILED, VERSION};
use crate::{
    film::Window,
    output::{Attribute, BlockShape, Value},
};

/// The headers of a file with scanlines or tiles.
pub(super) struct Headers {
    pub is_multi: bool,
    /// At least one.
    pub parts: Vec<Header>,
}

/// The header of a part.
pub(super) struct Header {
    /// The code of the compression.
    pub compression: u8,
    blocks: Blocks,
    pub display: Window,
    pub data: Window,
    /// In the order of the file.
    pub attributes: Vec<Attribute>,
}

/// The blocks of a part.
#[derive(Clone, Copy)]
enum Blocks {
    /// The number of lines of a block.
    Lines(u32),
    /// The number of columns and rows of a tile.
    Tiles([u32; 2]),
}

impl Header {
    /// The number of its blocks.
    pub fn blocks(&self) -> u64 {
        let [columns, rows] = self.grid();
        u64::from(columns) * u64::from(rows)
    }

    /// The number of columns and rows of blocks.
    fn grid(&self) -> [u32; 2] {
        let (width, height) = (self.data.width(), self.data.height());
        match self.blocks {
            Blocks::Lines(lines) => [1, height.div_ceil(lines)],
            Blocks::Tiles([columns, rows]) => [width.div_ceil(columns), height.div_ceil(rows)],
        }
    }

    pub fn block_shape(&self) -> BlockShape {
        match self.blocks {
            Blocks::Lines(_) => BlockShape::Lines,
            Blocks::Tiles(_) => BlockShape::Tiles,
        }
    }

    /// Reads the position of a block; returns whether it is within this part.
    pub fn read_place(&self, file: &mut impl Read) -> io::Result<bool> {
        let mut int = || take(file).map(i32::from_le_bytes);
        Ok(match self.blocks {
            Blocks::Lines(_) => (self.data.y0..self.data.y1).contains(&int()?),
            Blocks::Tiles(_) => {
                let place = [int()?, int()?];
                let levels = [int()?, int()?];
                let is_inside = |(at, count): (&i32, u32)| u32::try_from(*at).is_ok_and(|at| at < count);
                levels == [0; 2] && place.iter().zip(self.grid()).all(is_inside)
            }
        })
    }
}

impl Headers {
    /// Reads the headers; afterwards `file` is at their end. Attributes of types without a [`Value`] and of more than
    /// `max_attribute` bytes are left out. `None` for files of other kinds.
    ///
    /// # Errors
    /// The file cannot be read, or is too short.
    pub fn read(file: &mut (impl BufRead + Seek), max_attribute: usize) -> io::Result<Option<Self>> {
        let magic: [u8; 4] = take(file)?;
        let flags = u32::from_le_bytes(take(file)?) & !LONG_NAMES;
        // Other flags mean deep data.
        if magic != MAGIC || flags & !(MULTI_PART | TILED) != VERSION {
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
    /// The end of the headers.
    End,
    /// Attributes are missing, or the compression is unknown.
    Unfit,
}

fn read_header(file: &mut (impl BufRead + Seek), max_attribute: usize) -> io::Result<HeaderRead> {
    let (mut compression, mut attributes, mut is_empty) = (None, Vec::new(), true);
    let mut tiles = None;
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
        } else if name == b"tiles" && size == 9 {
            tiles = Some([take(file)?, take(file)?].map(u32::from_le_bytes));
            // Mipmaps are not supported.
            if take::<1>(file)? != [0] {
                return Ok(HeaderRead::Unfit);
            }
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
    let blocks = |lines| match tiles {
        Some(size) => Some(Blocks::Tiles(size)).filter(|_| !size.contains(&0)),
        None => Some(Blocks::Lines(lines)),
    };
    let compression = compression.and_then(|code| Some((code, blocks(lines_per_block(code)?)?)));
    Ok(match (compression, window("dataWindow"), window("displayWindow")) {
        _ if is_empty => HeaderRead::End,
        (Some((compression, blocks)), Some(data), Some(display)) => HeaderRead::Part(Header {
            compression,
            blocks,
            display,
            data,
            attributes,
        }),
        _ => HeaderRead::Unfit,
    })
}

fn lines_per_block(compression: u8) -> Option<u32> {
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
