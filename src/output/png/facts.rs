//! Facts of a PNG file, from its chunks.

use std::{
    io::{self, BufReader, Read, Seek, SeekFrom},
    path::Path,
};

use crate::{
    film::Window,
    output::{Attribute, FileFacts, facts::open},
};

/// The keyword of a crop's window.
pub const WINDOW: &str = "batch-render/window";

/// The facts of a file with a PNG signature and the final chunk.
pub(super) fn facts(path: &Path) -> io::Result<Option<FileFacts>> {
    const BEGIN: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
    const END: [u8; 12] = *b"\0\0\0\0IEND\xaeB`\x82";
    let mut file = BufReader::new(open(path)?);
    let (mut begin, mut end) = ([0; BEGIN.len()], [0; END.len()]);
    file.read_exact(&mut begin)?;
    file.seek(SeekFrom::End(-(END.len() as i64)))?;
    file.read_exact(&mut end)?;
    if begin != BEGIN || end != END {
        return Ok(None);
    }
    file.seek(SeekFrom::Start(BEGIN.len() as u64))?;
    let (mut resolution, mut attributes) = (None, Vec::new());
    loop {
        let (mut size, mut kind, mut checksum) = ([0; 4], [0; 4], [0; 4]);
        file.read_exact(&mut size)?;
        file.read_exact(&mut kind)?;
        let size = u32::from_be_bytes(size) as usize;
        match &kind {
            // This program writes texts before the pixels.
            b"IDAT" | b"IEND" => break,
            b"IHDR" | b"tEXt" | b"iTXt" if size <= FileFacts::MAX_ATTRIBUTE => {
                let mut bytes = vec![0; size];
                file.read_exact(&mut bytes)?;
                match bytes.as_chunks::<4>().0 {
                    [width, height, ..] if &kind == b"IHDR" => {
                        resolution = Some([width, height].map(|side| u32::from_be_bytes(*side)));
                    }
                    _ => attributes.extend(text_of(&kind, &bytes)),
                }
                file.read_exact(&mut checksum)?;
            }
            _ => file.seek_relative(size as i64 + 4)?,
        }
    }
    let told = attributes.iter().find(|a| a.name == WINDOW);
    let told = told.and_then(|a| parse_window(&a.value.to_string()));
    Ok(resolution.map(|size| {
        let (window, resolution) = told.unwrap_or((Window::full(size), size));
        FileFacts {
            resolution,
            window,
            attributes,
        }
    }))
}

/// The text of a `tEXt` or of an uncompressed `iTXt` chunk under its keyword.
fn text_of(kind: &[u8; 4], bytes: &[u8]) -> Option<Attribute> {
    let (keyword, mut text) = split_at_zero(bytes)?;
    if kind == b"iTXt" {
        let rest = text.strip_prefix(&[0, 0])?;
        let (_language, rest) = split_at_zero(rest)?;
        (_, text) = split_at_zero(rest)?;
    }
    let (keyword, text) = (str::from_utf8(keyword).ok()?, str::from_utf8(text).ok()?);
    Some(Attribute::new(keyword, text))
}

fn split_at_zero(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().position(|b| *b == 0)?;
    Some((&bytes[..end], &bytes[end + 1..]))
}

/// Parses a window and the size of its picture.
pub fn parse_window(text: &str) -> Option<(Window, [u32; 2])> {
    let (window, picture) = text.split_once(" of ")?;
    let size = |text: &str| -> Option<[u32; 2]> {
        let (width, height) = text.split_once('x')?;
        Some([width.parse().ok()?, height.parse().ok()?])
    };
    let mut signs = window.match_indices(['+', '-']).map(|(at, _)| at);
    let (x, y) = (signs.next()?, signs.next()?);
    let first = [window[x..y].parse().ok()?, window[y..].parse().ok()?];
    Some((Window::sized(first, size(&window[..x])?), size(picture)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_read_as_they_are_written() {
        let parsed = parse_window("4x3-2+1 of 640x480");
        assert_eq!(parsed, Some((Window::new(-2, 1, 2, 4), [640, 480])));
        assert_eq!(parse_window("4x3 of 640x480"), None);
    }
}
