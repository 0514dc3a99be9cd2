//! The facts of a complete file, all of whose blocks can be decoded.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Read, Seek, SeekFrom},
    path::Path,
};

use ::exr::block::{UncompressedBlock, reader::ChunksReader as _};

use super::header::{self, LONG_NAMES, MAGIC, VERSION};
use crate::output::{Attribute, FileFacts, Value, facts};

/// The facts of a single-part scanline file whose table of blocks is filled and whose blocks can all be decoded.
pub(super) fn inspect(path: &Path) -> Option<FileFacts> {
    let facts = facts::open(path).and_then(check).ok().flatten()?;
    let file = facts::open(path).ok()?;
    decode_blocks(file).ok()?;
    Some(facts)
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
    let Some(header) = read_header(&mut file)? else {
        return Ok(None);
    };
    let (y_min, y_max) = header.lines;
    let lines = i64::from(y_max) - i64::from(y_min) + 1;
    let Some(lines_per_block) = lines_per_block(header.compression) else {
        return Ok(None);
    };
    let table_start = file.stream_position()?;
    let blocks = u64::try_from(lines).unwrap_or(0).div_ceil(lines_per_block);
    let table_end = table_start + 8 * blocks;
    if blocks == 0 || table_end > length {
        return Ok(None);
    }
    let mut last = 0;
    for _ in 0..blocks {
        let offset = u64::from_le_bytes(take(&mut file)?);
        if offset < table_end || offset > length {
            return Ok(None);
        }
        last = last.max(offset);
    }
    file.seek(SeekFrom::Start(last))?;
    let y = i32::from_le_bytes(take(&mut file)?);
    let size = u64::from(u32::from_le_bytes(take(&mut file)?));
    let is_there = (y_min..=y_max).contains(&y) && last + 8 + size <= length;
    Ok(is_there.then_some(header.facts))
}

struct Header {
    compression: u8,
    /// The first and the last line of the data window.
    lines: (i32, i32),
    facts: FileFacts,
}

fn read_header(file: &mut BufReader<File>) -> io::Result<Option<Header>> {
    let magic: [u8; 4] = take(file)?;
    let version = u32::from_le_bytes(take(file)?);
    // Any other flag: tiles, deep data or several parts.
    if magic != MAGIC || version & !LONG_NAMES != VERSION {
        return Ok(None);
    }
    let (mut compression, mut attributes) = (None, Vec::new());
    loop {
        let name = name(file)?;
        if name.is_empty() {
            break;
        }
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
    let (Some(compression), Some(data), Some(display)) = (compression, window("dataWindow"), window("displayWindow"))
    else {
        return Ok(None);
    };
    Ok(Some(Header {
        compression,
        lines: (data.y0, data.y1.saturating_sub(1)),
        facts: FileFacts {
            resolution: [display.width(), display.height()],
            attributes,
        },
    }))
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
