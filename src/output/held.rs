//! Held files: open files that tell other processes that the one which made them lives, however it ends.
//!
//! On Unix a held file is locked. A lock of Windows would keep others from reading the file, so there it is open without leave
//! for others to write to it. In a folder that both share, neither sees whether the other's files are held; their names have a mark
//! that tells which these are.

use std::{
    fs::{self, File, OpenOptions},
    io,
    path::Path,
    time::{Duration, SystemTime},
};

/// The mark in the names of files that are held as on this system, before their suffix.
pub const MARK: &str = if cfg!(windows) { ".win" } else { "" };

/// The time without a change after which a file counts as abandoned, if it is held as on another system.
const LONGEST_SILENCE: Duration = Duration::from_secs(24 * 60 * 60);

/// Creates a file that is held while it is open. Where a network file system has no locks it looks abandoned.
#[cfg(not(windows))]
pub fn create(path: &Path) -> io::Result<File> {
    let file = OpenOptions::new().write(true).create_new(true).open(path)?;
    let _ = file.lock();
    Ok(file)
}

/// Opens a file and holds it; `None` if another process does.
#[cfg(not(windows))]
pub fn take(path: &Path) -> io::Result<Option<File>> {
    let file = OpenOptions::new().write(true).open(path)?;
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(std::fs::TryLockError::WouldBlock) => Ok(None),
        Err(std::fs::TryLockError::Error(error)) => Err(error),
    }
}

/// Creates a file that is held while it is open.
#[cfg(windows)]
pub fn create(path: &Path) -> io::Result<File> {
    open(OpenOptions::new().create_new(true), path)
}

/// Opens a file and holds it; `None` if another process does.
#[cfg(windows)]
pub fn take(path: &Path) -> io::Result<Option<File>> {
    match open(&mut OpenOptions::new(), path) {
        Ok(file) => Ok(Some(file)),
        Err(error) if is_in_use(&error) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Opens a file that others may read, rename and remove, but not write to.
#[cfg(windows)]
fn open(options: &mut OpenOptions, path: &Path) -> io::Result<File> {
    use std::os::windows::fs::OpenOptionsExt;
    const FILE_SHARE_READ: u32 = 1;
    const FILE_SHARE_DELETE: u32 = 4;
    options
        .write(true)
        .share_mode(FILE_SHARE_READ | FILE_SHARE_DELETE)
        .open(path)
}

/// Removes the files of a folder with these beginnings and endings of names which no process holds, and those with the mark of
/// another system that have not changed for a day.
pub fn remove_abandoned(folder: &Path, prefix: &str, suffix: &str) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let Some(name) = name.to_str() else { continue };
        let is_file = entry.file_type().is_ok_and(|t| t.is_file());
        if !is_file || !name.starts_with(prefix) || !name.ends_with(suffix) {
            continue;
        }
        let is_foreign = name.contains(".win.") != cfg!(windows);
        if is_foreign && !is_silent(&entry) {
            continue;
        }
        // Holding it keeps other processes from using the file.
        if let Ok(Some(_held)) = take(&entry.path()) {
            // Another process may have removed it already.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Whether a file has not changed for [`LONGEST_SILENCE`].
fn is_silent(entry: &fs::DirEntry) -> bool {
    let changed = entry.metadata().and_then(|found| found.modified());
    changed.is_ok_and(|changed| {
        SystemTime::now()
            .duration_since(changed)
            .is_ok_and(|time| time > LONGEST_SILENCE)
    })
}

/// Whether an error says that another process has the file open in a way that excludes this one, which Unix does not know.
pub fn is_in_use(error: &io::Error) -> bool {
    const SHARING_VIOLATION: i32 = 32;
    const LOCK_VIOLATION: i32 = 33;
    const USER_MAPPED_FILE: i32 = 1224;
    let code = error.raw_os_error();
    cfg!(windows) && matches!(code, Some(SHARING_VIOLATION | LOCK_VIOLATION | USER_MAPPED_FILE))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn files_of_another_system_are_abandoned_after_a_day() {
        let home = tempfile::tempdir().unwrap();
        let path = |name: &str, mark: &str| home.path().join(format!("p-{name}{mark}.tmp"));
        let foreign = if cfg!(windows) { "" } else { ".win" };
        for (name, mark) in [("a", MARK), ("a", foreign), ("old", foreign)] {
            fs::write(path(name, mark), "").unwrap();
        }
        let old = File::options().write(true).open(path("old", foreign)).unwrap();
        old.set_modified(SystemTime::now() - 2 * LONGEST_SILENCE).unwrap();
        drop(old);
        remove_abandoned(home.path(), "p-", ".tmp");
        let left: Vec<_> = fs::read_dir(home.path()).unwrap().flatten().map(|e| e.path()).collect();
        assert_eq!(left, [path("a", foreign)]);
    }

    #[test]
    fn a_held_file_can_be_read_and_renamed_and_is_taken_once_it_is_closed() {
        let home = tempfile::tempdir().unwrap();
        let [first, second] = ["a", "b"].map(|name| home.path().join(name));
        let mut file = create(&first).unwrap();
        file.write_all(b"text").unwrap();
        assert!(create(&first).is_err());
        assert!(take(&first).unwrap().is_none());
        fs::rename(&first, &second).unwrap();
        assert!(take(&second).unwrap().is_none());
        assert_eq!(fs::read(&second).unwrap(), b"text");
        drop(file);
        let taken = take(&second).unwrap();
        assert!(taken.is_some() && take(&second).unwrap().is_none());
        fs::remove_file(&second).unwrap();
        drop(taken);
        assert!(take(&second).is_err());
    }
}
