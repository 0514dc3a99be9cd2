//! Whether a file is complete, without decoding it.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Read, Seek, SeekFrom},
    path::Path,
};

use super::header::{LONG_NAMES, MAGIC, VERSION};

/// Whether `path` is a single-part scanline file whose table of blocks is filled and whose last block lies wholly in it.
pub(super) fn is_whole(path: &Path) -> bool {
    File::open(path).and_then(check).is_ok_and(|found| found.is_some())
}

/// `None` or an error if anything is missing.
fn check(file: File) -> io::Result<Option<()>> {
    let length = file.metadata()?.len();
    let mut file = BufReader::new(file);
    let Some(header) = read_header(&mut file)? else {
        return Ok(None);
    };
    let lines = i64::from(header.y_max) - i64::from(header.y_min) + 1;
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
    let is_there = (header.y_min..=header.y_max).contains(&y) && last + 8 + size <= length;
    Ok(is_there.then_some(()))
}

struct Header {
    compression: u8,
    y_min: i32,
    y_max: i32,
}

fn read_header(file: &mut BufReader<File>) -> io::Result<Option<Header>> {
    let magic: [u8; 4] = take(file)?;
    let version = u32::from_le_bytes(take(file)?);
    // Any other flag: tiles, deep data or several parts.
    if magic != MAGIC || version & !LONG_NAMES != VERSION {
        return Ok(None);
    }
    let (mut compression, mut window) = (None, None);
    loop {
        let name = name(file)?;
        if name.is_empty() {
            break;
        }
        let _kind = self::name(file)?;
        let size = u32::from_le_bytes(take(file)?);
        match name.as_slice() {
            b"compression" if size == 1 => compression = Some(take::<1>(file)?[0]),
            b"dataWindow" if size == 16 => window = Some(take::<16>(file)?),
            _ => file.seek_relative(i64::from(size))?,
        }
    }
    let (Some(compression), Some(window)) = (compression, window) else {
        return Ok(None);
    };
    let int = |i: usize| i32::from_le_bytes([window[i], window[i + 1], window[i + 2], window[i + 3]]);
    Ok(Some(Header {
        compression,
        y_min: int(4),
        y_max: int(12),
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
