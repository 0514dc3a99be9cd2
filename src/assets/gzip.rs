//! Model files compressed by gzip.

use std::{
    io::{self, Read},
    path::Path,
    sync::Arc,
};

use flate2::bufread::GzDecoder;

use super::{Files, MemoryBudget, MemoryKind};

/// The most bytes of a decompressed file.
const MOST: u64 = 2 << 30;
/// The largest compression ratio. The format's own limit is 1032, which only zeros reach.
const MOST_TIMES: u64 = 1024;

/// Whether a name ends in `.gz`.
pub(super) fn is_packed(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"))
}

/// Reads a file, and decompresses it if its name ends in `.gz`.
///
/// # Errors
/// The file cannot be read ([`Files::read`]). The kind is `InvalidInput` for broken data and for more than 2 GiB or 1024 times
/// the file's size, and `OutOfMemory` for more than the remaining memory.
pub(super) fn read(path: &Path, files: &Files) -> io::Result<Arc<[u8]>> {
    let bytes = files.read(path)?;
    match is_packed(path) {
        true => {
            let most = MOST.min((bytes.len() as u64).saturating_mul(MOST_TIMES));
            Ok(unpack(&bytes, most, files.memory())?.into())
        }
        false => Ok(bytes),
    }
}

/// Decompresses to at most `most` bytes.
fn unpack(bytes: &[u8], most: u64, memory: &MemoryBudget) -> io::Result<Vec<u8>> {
    let refuse = |cause: String| io::Error::new(io::ErrorKind::InvalidInput, cause);
    let mut source = GzDecoder::new(bytes);
    let (mut out, mut chunk) = (Vec::new(), vec![0; 1 << 16]);
    loop {
        let count = source
            .read(&mut chunk)
            .map_err(|e| refuse(format!("broken gzip data: {e}")))?;
        if count == 0 {
            let rest = source.into_inner();
            // Archivers and tapes pad files with zeros.
            if rest.iter().all(|byte| *byte == 0) {
                return Ok(out);
            }
            source = GzDecoder::new(rest);
            continue;
        }
        let length = out.len() + count;
        if length as u64 > most {
            return Err(refuse(format!(
                "it unpacks to more than the {most} bytes that are allowed"
            )));
        }
        if length > out.capacity() {
            // While the buffer grows to twice its size, the old one still exists.
            memory
                .check(MemoryKind::Models, 3 * length as u64)
                .map_err(|over| io::Error::new(io::ErrorKind::OutOfMemory, over))?;
        }
        out.extend_from_slice(&chunk[..count]);
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn pack(bytes: &[u8]) -> Vec<u8> {
        let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        out.write_all(bytes).expect("memory");
        out.finish().expect("memory")
    }

    #[test]
    fn what_was_packed_comes_out_again() {
        let bytes: Vec<u8> = (0..100_000_u32).map(|i| (i.wrapping_mul(i) >> 7) as u8).collect();
        let unpack = |packed: &[u8]| unpack(packed, MOST, &MemoryBudget::default()).expect("sound");
        assert_eq!(unpack(&pack(&bytes)), bytes);
        // A file may hold several streams.
        assert_eq!(unpack(&[pack(b"one "), pack(b"two")].concat()), b"one two");
        assert_eq!(unpack(&[pack(b"padded"), vec![0; 700]].concat()), b"padded");
    }

    #[test]
    fn bombs_and_broken_files_are_refused() {
        let packed = pack(&vec![0; 16 << 20]);
        let kind = |bytes: &[u8], most, memory| unpack(bytes, most, &MemoryBudget::new(memory)).map_err(|e| e.kind());
        assert!(kind(&packed, 16 << 20, None).is_ok());
        assert_eq!(kind(&packed, (16 << 20) - 1, None), Err(io::ErrorKind::InvalidInput));
        assert_eq!(kind(&packed, MOST, Some(1 << 20)), Err(io::ErrorKind::OutOfMemory));
        let half = &packed[..packed.len() / 2];
        assert_eq!(kind(half, MOST, None), Err(io::ErrorKind::InvalidInput));
        assert_eq!(kind(b"no gzip", MOST, None), Err(io::ErrorKind::InvalidInput));
        let followed = [pack(b"one"), vec![0, 1]].concat();
        assert_eq!(kind(&followed, MOST, None), Err(io::ErrorKind::InvalidInput));
    }

    #[test]
    fn the_name_of_a_file_tells_whether_it_is_unpacked() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let read = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).expect("written");
            read(&path, &Files::default()).map(|b| b.to_vec())
        };
        let packed = pack(b"solid");
        assert_eq!(read("a.stl.GZ", &packed).expect("sound"), b"solid");
        assert_eq!(read("a.stl", &packed).expect("read as it is"), packed);
        assert!(read("b.stl.gz", b"solid").is_err());
    }
}
