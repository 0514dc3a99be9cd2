//! The files that a scene was read from, and whether they have changed since.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
    time::{Duration, SystemTime},
};

use crate::assets::{ContentHash, Files};

/// The coarsest step of modification times: that of FAT file systems.
const TIME_STEP: Duration = Duration::from_secs(2);

/// The files of a scene, with their contents when they were read.
pub struct InputFiles(Mutex<Vec<InputFile>>);

struct InputFile {
    path: PathBuf,
    hash: ContentHash,
    /// The time and size at the last look; `None` if the content was not compared yet or there is no such file.
    stamp: Option<Stamp>,
    has_changed: bool,
}

/// The modification time and the size of a file.
type Stamp = (SystemTime, u64);

impl InputFiles {
    /// The files of `manifest`, which were read after the time `begun`.
    pub fn new(manifest: Vec<(PathBuf, ContentHash)>, begun: SystemTime) -> Self {
        let is_older = |(time, _): &Stamp| begun.duration_since(*time).is_ok_and(|age| age > TIME_STEP);
        let file = |(path, hash): (PathBuf, ContentHash)| InputFile {
            // A younger file may have changed after it was read.
            stamp: stamp(&path).filter(is_older),
            path,
            hash,
            has_changed: false,
        };
        Self(Mutex::new(manifest.into_iter().map(file).collect()))
    }

    /// Whether a file has another content than when it was read, or is gone. Reads only files with another time or size than at the
    /// last call.
    pub fn have_changed(&self) -> bool {
        let mut files = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // All files are looked at, so that none of them is read twice.
        files.iter_mut().fold(false, |any, file| file.look_again() | any)
    }
}

impl InputFile {
    fn look_again(&mut self) -> bool {
        let stamp = stamp(&self.path);
        if stamp.is_none() || stamp != self.stamp {
            self.stamp = stamp;
            let bytes = Files::default().read(&self.path);
            self.has_changed = !bytes.is_ok_and(|bytes| ContentHash::of(&bytes) == self.hash);
        }
        self.has_changed
    }
}

fn stamp(path: &Path) -> Option<Stamp> {
    let found = fs::metadata(path).ok()?;
    Some((found.modified().ok()?, found.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_have_changed_while_their_contents_are_others() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        let write = |name: &str, text: &str| fs::write(path(name), text).expect("written");
        let read = Files::default();
        for name in ["a", "b"] {
            write(name, "one");
            read.read(&path(name)).expect("readable");
        }
        // Of the same size, before the first look.
        write("b", "two");
        let files = InputFiles::new(read.manifest(), SystemTime::now());
        assert!(files.have_changed() && files.have_changed());
        write("b", "one");
        assert!(!files.have_changed() && !files.have_changed());
        write("a", "three");
        assert!(files.have_changed() && files.have_changed());
        write("a", "one");
        assert!(!files.have_changed());
        fs::remove_file(path("a")).expect("removed");
        assert!(files.have_changed() && files.have_changed());
        write("a", "one");
        assert!(!files.have_changed());
    }

    #[test]
    fn files_that_were_old_when_they_were_read_are_not_read_again() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a");
        fs::write(&path, "one").expect("written");
        let manifest = vec![(path.clone(), ContentHash::of(b"other"))];
        let later = SystemTime::now() + 2 * TIME_STEP;
        assert!(!InputFiles::new(manifest.clone(), later).have_changed());
        assert!(InputFiles::new(manifest, SystemTime::now()).have_changed());
    }
}
