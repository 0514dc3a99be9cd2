//! Seals: a checksum inside of a file, which detects any change of its bytes.
//!
//! A sealed file has the text attribute [`NAME`]: 32 hexadecimal digits, the first 128 bits of BLAKE3 over all bytes of the file
//! with these digits as zeros. In PNG files the checksum of the text's own chunk, the four bytes behind the digits, counts as
//! zeros too.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom, Write},
    ops::Range,
    panic::resume_unwind,
    path::Path,
    sync::{Mutex, PoisonError},
    thread::{self, Builder},
};

use super::facts;
use crate::assets::ContentHash;

/// The name of the attribute.
pub const NAME: &str = "batch-render/checksum";

/// The value of the attribute before the file is sealed.
pub const PLACEHOLDER: &str = "00000000000000000000000000000000";

const DIGITS: usize = PLACEHOLDER.len();

/// The type of the attribute in an EXR file, and the number of the digits.
const TYPE_AND_LENGTH: &[u8] = b"\0string\0\x20\0\0\0";

/// The attribute lies within the first bytes of a file.
const HEAD: usize = 1 << 16;

/// The bytes from which on a thread of their own hashes them: it starts in less time than these take.
const LARGE: usize = 1 << 20;

/// The most bytes that are written at once. Linux may take ten times as long for parts of some megabytes: it asks
/// for large pages of its cache then.
const PART: usize = 1 << 18;

/// The bytes that are read at once.
const CHUNK: usize = 1 << 20;

/// The bytes of the attribute as EXR files hold it, for formats without attributes.
pub(super) fn attribute() -> Vec<u8> {
    [NAME.as_bytes(), TYPE_AND_LENGTH, PLACEHOLDER.as_bytes()].concat()
}

/// The place of a seal.
struct Place {
    digits: Range<usize>,
    /// The bytes of a PNG chunk that its checksum covers, its type and its data.
    chunk: Option<Range<usize>>,
}

impl Place {
    /// The place of the seal in a file that begins with `head`.
    fn find(head: &[u8]) -> Option<Self> {
        let mut before = NAME.as_bytes().to_vec();
        let is_png = head.starts_with(b"\x89PNG");
        if is_png {
            before.push(0);
        } else {
            before.extend(TYPE_AND_LENGTH);
        }
        let at = head.windows(before.len()).position(|bytes| bytes == before)?;
        let digits = at + before.len()..at + before.len() + DIGITS;
        let chunk = is_png.then(|| at.saturating_sub(4)..digits.end);
        let end = digits.end + if is_png { 4 } else { 0 };
        (end <= head.len()).then_some(Self { digits, chunk })
    }

    /// Makes zeros of what the checksum does not cover. Returns the digits that were there.
    fn clear(&self, head: &mut [u8]) -> [u8; DIGITS] {
        let mut digits = [0; DIGITS];
        digits.copy_from_slice(&head[self.digits.clone()]);
        head[self.digits.clone()].fill(b'0');
        if let Some(chunk) = &self.chunk {
            head[chunk.end..chunk.end + 4].fill(0);
        }
        digits
    }

    /// Puts the digits of the checksum into a file that begins with `head`; returns the end of the bytes that this changes.
    fn put(&self, head: &mut [u8], digits: &[u8]) -> usize {
        head[self.digits.clone()].copy_from_slice(digits);
        let Some(chunk) = &self.chunk else {
            return self.digits.end;
        };
        let checksum = crc32fast::hash(&head[chunk.clone()]);
        head[chunk.end..chunk.end + 4].copy_from_slice(&checksum.to_be_bytes());
        chunk.end + 4
    }
}

/// Seals the whole bytes of a file that has the placeholder; others stay as they are.
pub(super) fn seal(bytes: &mut [u8]) {
    let head = bytes.len().min(HEAD);
    let Some(place) = Place::find(&bytes[..head]) else {
        return;
    };
    place.clear(bytes);
    let digits = ContentHash::of(bytes).to_string();
    place.put(bytes, digits.as_bytes());
}

/// Seals a new file while it is written: passes its bytes on, and hashes them.
pub(super) struct Sealing<W> {
    out: W,
    /// The first bytes of the file, in which the seal is.
    head: Vec<u8>,
    /// Whether the first bytes are passed on.
    is_past_head: bool,
    place: Option<Place>,
    hasher: blake3::Hasher,
}

impl<W: Write + Seek> Sealing<W> {
    pub fn new(out: W) -> Self {
        Self {
            out,
            head: Vec::new(),
            is_past_head: false,
            place: None,
            hasher: blake3::Hasher::new(),
        }
    }

    fn pass_head(&mut self) -> io::Result<()> {
        self.is_past_head = true;
        self.place = Place::find(&self.head);
        if let Some(place) = &self.place {
            place.clear(&mut self.head);
        }
        self.hasher.update(&self.head);
        self.out.write_all(&self.head)
    }

    /// Writes bytes while another thread hashes them, which takes as long.
    fn write_large(&mut self, bytes: &[u8]) -> io::Result<()> {
        let Self { out, hasher, .. } = self;
        let hasher = Mutex::new(hasher);
        let hash = || {
            hasher.lock().unwrap_or_else(PoisonError::into_inner).update(bytes);
        };
        thread::scope(|scope| {
            let hashing = Builder::new().spawn_scoped(scope, hash);
            let written = bytes.chunks(PART).try_for_each(|part| out.write_all(part));
            // Where there are no more threads, this one hashes.
            match hashing {
                Ok(thread) => thread.join().unwrap_or_else(|panic| resume_unwind(panic)),
                Err(_) => hash(),
            }
            written
        })
    }

    /// Writes the seal, if the file has the placeholder.
    pub fn finish(mut self) -> io::Result<()> {
        if !self.is_past_head {
            self.pass_head()?;
        }
        if let Some(place) = self.place {
            let digits = self.hasher.finalize().to_hex();
            let end = place.put(&mut self.head, &digits.as_bytes()[..DIGITS]);
            self.out.seek(SeekFrom::Start(place.digits.start as u64))?;
            self.out.write_all(&self.head[place.digits.start..end])?;
        }
        self.out.flush()
    }
}

impl<W: Write + Seek> Write for Sealing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_past_head {
            if bytes.len() < LARGE {
                self.out.write_all(bytes)?;
                self.hasher.update(bytes);
            } else {
                self.write_large(bytes)?;
            }
            return Ok(bytes.len());
        }
        let length = bytes.len().min(HEAD - self.head.len());
        self.head.extend(&bytes[..length]);
        if self.head.len() == HEAD {
            self.pass_head()?;
        }
        Ok(length)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Whether the file at `path` has the bytes that it was sealed with; `None` of a file that was not sealed.
///
/// # Errors
/// The file cannot be read.
pub(super) fn is_intact(path: &Path) -> io::Result<Option<bool>> {
    let mut file = facts::open(path)?;
    let mut chunk = vec![0; CHUNK];
    let mut length = fill(&mut file, &mut chunk)?;
    let head = length.min(HEAD);
    let Some(place) = Place::find(&chunk[..head]) else {
        return Ok(None);
    };
    let digits = place.clear(&mut chunk);
    if digits == PLACEHOLDER.as_bytes() {
        return Ok(None);
    }
    let mut hasher = blake3::Hasher::new();
    while length > 0 {
        hasher.update(&chunk[..length]);
        length = fill(&mut file, &mut chunk)?;
    }
    let found = hasher.finalize().to_hex();
    Ok(Some(found.as_bytes()[..DIGITS] == digits))
}

/// Reads as many bytes as fit; fewer only at the end of the file.
fn fill(file: &mut File, bytes: &mut [u8]) -> io::Result<usize> {
    let mut length = 0;
    while length < bytes.len() {
        match file.read(&mut bytes[length..]) {
            Ok(0) => break,
            Ok(n) => length += n,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(length)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// The bytes of a made-up file with the seal's attribute in the form of EXR, and `more` bytes behind it.
    fn file(more: usize) -> Vec<u8> {
        let mut bytes = b"v/1\x01 begins ".to_vec();
        bytes.extend(NAME.as_bytes());
        bytes.extend(b"\0string\0\x20\0\0\0");
        bytes.extend(PLACEHOLDER.as_bytes());
        bytes.extend((0..more).map(|i| i as u8));
        seal(&mut bytes);
        bytes
    }

    #[test]
    fn every_flipped_bit_and_every_missing_byte_is_found() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("a");
        let sealed = file(100);
        let check = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            is_intact(&path).unwrap()
        };
        assert_eq!(check(&sealed), Some(true));
        for byte in 0..sealed.len() {
            let mut flipped = sealed.clone();
            flipped[byte] ^= 1 << (byte % 8);
            assert_ne!(check(&flipped), Some(true), "byte {byte}");
            assert_ne!(check(&sealed[..byte]), Some(true), "{byte} bytes");
        }
        assert_eq!(check(&[&sealed[..], b"x"].concat()), Some(false));
    }

    #[test]
    fn the_seal_of_a_file_does_not_depend_on_the_sizes_of_its_writes() {
        let bytes = [file(0), (0..3 * LARGE).map(|i| (i % 251) as u8).collect()].concat();
        let mut whole = bytes.clone();
        seal(&mut whole);
        for size in [HEAD, LARGE - 1, LARGE, 2 * LARGE + 3, bytes.len()] {
            let mut written = Cursor::new(Vec::new());
            let mut out = Sealing::new(&mut written);
            bytes.chunks(size).for_each(|part| out.write_all(part).unwrap());
            out.finish().unwrap();
            assert_eq!(written.into_inner(), whole, "{size}");
        }
    }

    #[test]
    fn a_file_of_several_chunks_is_read_whole() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("a");
        let mut sealed = file(2 * CHUNK + 17);
        std::fs::write(&path, &sealed).unwrap();
        assert_eq!(is_intact(&path).unwrap(), Some(true));
        *sealed.last_mut().unwrap() ^= 1;
        std::fs::write(&path, &sealed).unwrap();
        assert_eq!(is_intact(&path).unwrap(), Some(false));
        std::fs::write(&path, b"another program's").unwrap();
        assert_eq!(is_intact(&path).unwrap(), None);
    }
}
