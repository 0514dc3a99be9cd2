//! The facts of a complete file: its seal fits its bytes, or, without a seal, all of its blocks can be decoded.

use std::{
    fs::File,
    io::{self, BufReader, Seek, SeekFrom},
    path::Path,
};

use ::exr::block::{UncompressedBlock, reader::ChunksReader as _};

use super::headers::{Header, Headers, take};
use crate::output::{FileFacts, facts, seal};

/// The facts of the first part of a file with scanlines or tiles, if its table of blocks is complete.
pub(super) fn facts(path: &Path) -> Option<FileFacts> {
    facts::open(path).and_then(check).ok().flatten()
}

/// The facts of a file whose seal fits. In a file without a seal, of another program, all blocks must be decodable.
pub(super) fn inspect(path: &Path) -> Option<FileFacts> {
    let facts = self::facts(path)?;
    let is_whole = match seal::is_intact(path).ok()? {
        Some(is_intact) => is_intact,
        None => facts.version().is_none() && decode_blocks(facts::open(path).ok()?).is_ok(),
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
    let Some(Headers { is_multi, parts }) = Headers::read(&mut file, FileFacts::MAX_ATTRIBUTE)? else {
        return Ok(None);
    };
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
    let is_in_place = parts[last_part].read_place(&mut file)?;
    let size = u64::from(u32::from_le_bytes(take(&mut file)?));
    let is_there = is_in_place && file.stream_position()? + size <= length;
    Ok(parts.into_iter().next().filter(|_| is_there).map(|part| FileFacts {
        resolution: [part.display.width(), part.display.height()],
        window: part.data,
        attributes: part.attributes,
    }))
}
