//! The reading of input files.
//!
//! Every input file of a job (the scene file, models, images and the camera path) is read by [`Files::read`], which records the
//! file's path and a hash of its content. Nothing else in the library opens an input file, so a picture depends only on
//! [`Files::manifest`] and the request.

use std::{
    collections::BTreeMap,
    fmt, fs, io,
    path::{Component, Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, SystemTime},
};

use super::{MemoryBudget, MemoryKind};
use crate::warnings::Warnings;

/// A file of this age has not changed lately. The clocks of file servers differ by less.
const OLD: Duration = Duration::from_secs(3600);

/// The first 128 bits of the BLAKE3 hash of a file's bytes.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ContentHash([u8; 16]);

impl ContentHash {
    pub fn of(bytes: &[u8]) -> Self {
        let mut hash = [0; 16];
        hash.copy_from_slice(&blake3::hash(bytes).as_bytes()[..16]);
        Self(hash)
    }

    pub fn as_bytes(&self) -> &[u8; 16] {
        &self.0
    }
}

/// 32 hexadecimal digits, as `b3sum --length 16` prints them.
impl fmt::Display for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// The path and the content of an input file that is not on disk.
pub type SuppliedFile = (PathBuf, Arc<[u8]>);

/// Reads input files and keeps a record of them.
#[derive(Debug, Default)]
pub struct Files {
    /// Whether models may name files outside of their folders.
    allow_outside: bool,
    memory: MemoryBudget,
    warnings: Warnings,
    supplied: Option<SuppliedFile>,
    read: Mutex<BTreeMap<PathBuf, ContentHash>>,
}

impl Files {
    /// A record without files. With `allow_outside` models may name files outside of their folders. The contents
    /// of files count against `memory`.
    pub fn new(allow_outside: bool, memory: MemoryBudget) -> Self {
        Self {
            allow_outside,
            memory,
            ..Self::default()
        }
    }

    /// The same, which collects the warnings about files in `warnings`.
    pub fn with_warnings(mut self, warnings: Warnings) -> Self {
        self.warnings = warnings;
        self
    }

    /// The same with a file of this path and content, whatever is on disk.
    pub fn with_supplied(mut self, file: Option<SuppliedFile>) -> Self {
        self.supplied = file;
        self
    }

    /// The warnings about files so far.
    pub fn warnings(&self) -> &Warnings {
        &self.warnings
    }

    /// The memory that the job may take.
    pub fn memory(&self) -> &MemoryBudget {
        &self.memory
    }

    /// Whether a model in the folder `root` may name the file at `path`. Only the text of the path counts; symbolic links inside
    /// of the folder may lead anywhere.
    pub fn allows(&self, root: &Path, path: &Path) -> bool {
        if self.allow_outside {
            return true;
        }
        let Ok(inner) = path.strip_prefix(root) else {
            return false;
        };
        let mut depth = 0;
        inner.components().all(|part| {
            match part {
                Component::Normal(_) => depth += 1,
                Component::ParentDir => depth -= 1,
                Component::CurDir => {}
                Component::RootDir | Component::Prefix(_) => return false,
            }
            depth >= 0
        })
    }

    /// Reads a regular file. Only files that could be read are recorded, with their last content.
    ///
    /// # Errors
    /// The file cannot be read. The kind is `InvalidInput` for anything but a regular file, such as a named pipe, which could
    /// block, or a device without an end, and `OutOfMemory` for a file that exceeds the remaining memory.
    pub fn read(&self, path: &Path) -> io::Result<Arc<[u8]>> {
        let supplied = self.supplied.as_ref().filter(|(other, _)| other == path);
        let bytes = match supplied {
            Some((_, bytes)) => Arc::clone(bytes),
            None => self.read_from_disk(path)?,
        };
        let hash = ContentHash::of(&bytes);
        let mut read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        read.insert(path.to_owned(), hash);
        Ok(bytes)
    }

    fn read_from_disk(&self, path: &Path) -> io::Result<Arc<[u8]>> {
        let found = fs::metadata(path)?;
        if !found.is_file() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file"));
        }
        self.memory
            .check(MemoryKind::Models, found.len())
            .map_err(|over| io::Error::new(io::ErrorKind::OutOfMemory, over))?;
        Ok(fs::read(path)?.into())
    }

    /// The hash of the content of a file that was read.
    pub fn hash(&self, path: &Path) -> Option<ContentHash> {
        let read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        read.get(path).copied()
    }

    /// Whether all files that were read since `time` still have the same contents. Those that were modified more than an hour
    /// before are not read again.
    pub fn are_unchanged_since(&self, time: SystemTime) -> bool {
        let is_old = |path: &Path| {
            let modified = fs::metadata(path).and_then(|found| found.modified());
            modified.is_ok_and(|modified| modified.checked_add(OLD).is_some_and(|end| end < time))
        };
        let is_same =
            |path: &Path, hash| is_old(path) || fs::read(path).is_ok_and(|bytes| ContentHash::of(&bytes) == hash);
        self.manifest().iter().all(|(path, hash)| is_same(path, *hash))
    }

    /// All files that were read, sorted by path.
    pub fn manifest(&self) -> Vec<(PathBuf, ContentHash)> {
        let read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        read.iter().map(|(path, hash)| (path.clone(), *hash)).collect()
    }
}

/// Whether a file exists but [`Files::read`] refused it: it is no regular file, or too large.
pub fn is_refused(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::OutOfMemory)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_beginning_of_blake3() {
        // The test vector of the empty input.
        assert_eq!(ContentHash::of(b"").to_string(), "af1349b9f5f9a1a6a0404dea36dcc949");
    }

    #[test]
    fn paths_stay_in_the_folder_unless_they_may_leave_it() {
        let gate = Files::default();
        let root = Path::new("models");
        for (path, inside) in [
            ("models/a.png", true),
            ("models/mtl/../tex/a.png", true),
            ("models/../a.png", false),
            ("models/mtl/../../a.png", false),
            ("/etc/passwd", false),
        ] {
            assert_eq!(gate.allows(root, Path::new(path)), inside, "{path}");
            assert!(Files::new(true, MemoryBudget::default()).allows(root, Path::new(path)));
        }
        assert!(gate.allows(Path::new(""), Path::new("a.png")));
        assert!(!gate.allows(Path::new(""), Path::new("../a.png")));
    }

    #[test]
    fn only_regular_files_are_read() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let error = Files::default().read(folder.path()).expect_err("a folder");
        assert!(is_refused(&error), "{error}");
        #[cfg(target_os = "linux")]
        assert!(is_refused(
            &Files::default().read(Path::new("/dev/zero")).expect_err("a device")
        ));
    }

    #[test]
    fn the_manifest_is_sorted_and_tells_contents_apart() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        for (name, text) in [("b", "one"), ("a", "one"), ("c", "two")] {
            fs::write(path(name), text).expect("written");
        }
        let files = Files::default();
        for name in ["c", "a", "b", "c"] {
            files.read(&path(name)).expect("readable");
        }
        assert!(files.read(&path("absent")).is_err());
        let manifest = files.manifest();
        let paths: Vec<_> = manifest.iter().map(|(p, _)| p.clone()).collect();
        assert_eq!(paths, ["a", "b", "c"].map(path));
        assert!(manifest[0].1 == manifest[1].1 && manifest[1].1 != manifest[2].1);

        fs::write(path("c"), "three").expect("written");
        files.read(&path("c")).expect("readable");
        assert_eq!(files.manifest()[2].1, ContentHash::of(b"three"));
    }

    #[test]
    fn a_file_with_other_bytes_or_none_has_changed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a");
        let (files, now) = (Files::default(), SystemTime::now());
        let write = |text: &str| fs::write(&path, text).expect("written");
        write("one");
        files.read(&path).expect("readable");
        assert!(files.are_unchanged_since(now));
        write("two");
        assert!(!files.are_unchanged_since(now));
        write("one");
        assert!(files.are_unchanged_since(now));
        fs::remove_file(&path).expect("removed");
        assert!(!files.are_unchanged_since(now));
        assert!(Files::default().are_unchanged_since(now));
    }
}
