//! The facts of a complete file: it has the bytes that it was sealed with, or all of its blocks can be decoded.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Read, Seek, SeekFrom},
    path::Path,
};

use ::exr::block::{UncompressedBlock, reader::ChunksReader as _};

use super::header::{self, LONG_NAMES, MAGIC, MULTI_PART, VERSION};
use crate::output::{Attribute, FileFacts, Value, facts, seal};

/// The facts of a scanline file, those of its first part, whose table of blocks is filled and whose bytes are those of its seal; of
/// one without a seal all blocks can be decoded.
pub(super) fn inspect(path: &Path) -> Option<FileFacts> {
    let facts = facts::open(path).and_then(check).ok().flatten()?;
    let is_whole = match seal::is_intact(path).ok()? {
        Some(is_intact) => is_intact,
        None => decode_blocks(facts::open(path).ok()?).is_ok(),
    };
    is_whole.then_some(facts)
}

/// Decodes all blocks and drops their pixels.
fn decode_blocks(file: File) -> ::exr::error::UnitResult {
    let mut chunks = ::exr::block::read(BufReader::new(file), true)?.all_chunks(true)?;
    let meta = chunks.meta_data().clone();
    chunks.try_for_each(|chunk| UncompressedBlock::decompress_chunk(chunk?, &meta, true).map(drop))
}

/// `None` or an error if anything is missing.
fn check(file: File) -> io::Result<Option<FileFacts>> {
    let length = file.metadata()?.len();
    let mut file = BufReader::new(file);
    let magic: [u8; 4] = take(&mut file)?;
    let flags = u32::from_le_bytes(take(&mut file)?) & !LONG_NAMES;
    // Any other flag: tiles or deep data.
    if magic != MAGIC || flags & !MULTI_PART != VERSION {
        return Ok(None);
    }
    let is_multi = flags & MULTI_PART != 0;
    let mut parts = Vec::new();
    while parts.is_empty() || is_multi {
        match read_header(&mut file)? {
            HeaderRead::Part(part) => parts.push(part),
            HeaderRead::End if !parts.is_empty() => break,
            HeaderRead::End | HeaderRead::Unfit => return Ok(None),
        }
    }
    let blocks: u64 = parts.iter().map(Header::blocks).sum();
    let table_end = file.stream_position()? + 8 * blocks;
    if parts.iter().any(|part| part.blocks() == 0) || table_end > length {
        return Ok(None);
    }
    let (mut last, mut last_part) = (0, 0);
    for (i, part) in parts.iter().enumerate() {
        for _ in 0..part.blocks() {
            let offset = u64::from_le_bytes(take(&mut file)?);
            if offset < table_end || offset > length {
                return Ok(None);
            }
            if offset > last {
                (last, last_part) = (offset, i);
            }
        }
    }
    file.seek(SeekFrom::Start(last))?;
    if is_multi {
        file.seek_relative(4)?;
    }
    let y = i32::from_le_bytes(take(&mut file)?);
    let size = u64::from(u32::from_le_bytes(take(&mut file)?));
    let (y_min, y_max) = parts[last_part].lines;
    let is_there = (y_min..=y_max).contains(&y) && file.stream_position()? + size <= length;
    Ok(parts.into_iter().next().filter(|_| is_there).map(|part| part.facts))
}

struct Header {
    lines_per_block: u64,
    /// The first and the last line of the data window.
    lines: (i32, i32),
    facts: FileFacts,
}

impl Header {
    /// The number of its blocks.
    fn blocks(&self) -> u64 {
        let (y_min, y_max) = self.lines;
        let lines = i64::from(y_max) - i64::from(y_min) + 1;
        u64::try_from(lines).unwrap_or(0).div_ceil(self.lines_per_block)
    }
}

enum HeaderRead {
    Part(Header),
    /// No attribute: the end of the headers.
    End,
    /// Attributes are missing, or the compression is unknown.
    Unfit,
}

fn read_header(file: &mut BufReader<File>) -> io::Result<HeaderRead> {
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
        } else if size as usize <= FileFacts::MAX_ATTRIBUTE {
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
    let lines_per_block = compression.and_then(lines_per_block);
    Ok(match (lines_per_block, window("dataWindow"), window("displayWindow")) {
        _ if is_empty => HeaderRead::End,
        (Some(lines_per_block), Some(data), Some(display)) => HeaderRead::Part(Header {
            lines_per_block,
            lines: (data.y0, data.y1.saturating_sub(1)),
            facts: FileFacts {
                resolution: [display.width(), display.height()],
                attributes,
            },
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

fn take<const N: usize>(file: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}
