//! Job files: a running job lists the files that it writes, so that two jobs do not write the same file.
//!
//! A job file is held (see `held`) as long as its process lives, and removed at the end or by the next job. It is a hidden
//! temporary file in the folder of the pictures, see [`atomic`](super::atomic).

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Write},
    path::{Path, PathBuf},
    thread,
    time::Duration,
};

use tempfile::NamedTempFile;

use super::{
    atomic::{TEMPORARY_PREFIX, TEMPORARY_SUFFIX},
    held,
};
use crate::render::Cancel;

const SUFFIX: &str = ".job.tmp";

/// The interval of attempts to lock a file.
const POLL: Duration = Duration::from_millis(5);

/// The time that a cancelled job waits for a lock.
const PATIENCE: Duration = Duration::from_millis(500);

/// A job's own file, removed on drop.
#[derive(Debug)]
pub struct JobFile {
    _file: NamedTempFile<File>,
}

/// A lock on the files of a folder that several jobs change, their job files among them. It is the lock on a hidden file there,
/// which works on network file systems too, and does nothing where no file can be made or locked.
#[derive(Debug)]
pub struct FolderGate {
    path: PathBuf,
    file: Option<File>,
}

impl FolderGate {
    /// Waits for the lock; once the job is cancelled, for a moment at most.
    pub fn close(folder: &Path, cancel: Option<&Cancel>) -> Self {
        let path = folder.join(format!("{TEMPORARY_PREFIX}gate{TEMPORARY_SUFFIX}"));
        let mut left = PATIENCE;
        loop {
            match attempt(&path) {
                Attempt::Closed(file) => return Self { path, file: Some(file) },
                Attempt::Busy if !left.is_zero() => {
                    thread::sleep(POLL);
                    if cancel.is_some_and(Cancel::is_cancelled) {
                        left = left.saturating_sub(POLL);
                    }
                }
                Attempt::Busy | Attempt::Impossible => return Self { path, file: None },
            }
        }
    }
}

impl Drop for FolderGate {
    fn drop(&mut self) {
        if self.file.is_some() && !cfg!(windows) {
            // A file that stays is a lock that nobody holds.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// What came of closing a gate.
enum Attempt {
    Closed(File),
    /// Another process has closed it.
    Busy,
    /// No file can be made or locked.
    Impossible,
}

/// Closes the gate at `path` if it is open.
#[cfg(not(windows))]
fn attempt(path: &Path) -> Attempt {
    // Opening anything but a file may wait for ever.
    if fs::symlink_metadata(path).is_ok_and(|found| !found.is_file()) {
        return Attempt::Impossible;
    }
    loop {
        let Ok(file) = OpenOptions::new().write(true).create(true).truncate(false).open(path) else {
            return Attempt::Impossible;
        };
        match file.try_lock() {
            // The job that held it has removed it: others lock a new file.
            Ok(()) if !is_at(&file, path) => {}
            Ok(()) => return Attempt::Closed(file),
            Err(std::fs::TryLockError::WouldBlock) => return Attempt::Busy,
            Err(_) => return Attempt::Impossible,
        }
    }
}

/// Closes the gate at `path` if it is open: the file is there for this process alone, and goes when it is closed.
#[cfg(windows)]
fn attempt(path: &Path) -> Attempt {
    use std::os::windows::fs::OpenOptionsExt;
    const FILE_FLAG_DELETE_ON_CLOSE: u32 = 0x0400_0000;
    let mut options = OpenOptions::new();
    options.write(true).create(true).truncate(false).share_mode(0);
    match options.custom_flags(FILE_FLAG_DELETE_ON_CLOSE).open(path) {
        Ok(file) => Attempt::Closed(file),
        Err(error) if held::is_in_use(&error) => Attempt::Busy,
        Err(_) => Attempt::Impossible,
    }
}

/// Whether `path` is the name of this open file.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |found: fs::Metadata| (found.dev(), found.ino());
    let own = file.metadata().map(identity);
    own.is_ok_and(|own| fs::metadata(path).is_ok_and(|found| identity(found) == own))
}

#[cfg(not(any(unix, windows)))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// This process and, on Linux, its machine, as text.
pub fn process() -> String {
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let host = Some(host.trim()).filter(|host| !host.is_empty());
    let host = host.map(|host| format!(" on {host}")).unwrap_or_default();
    format!("process {}{host}", std::process::id())
}

/// Makes a job file with this text in `folder`.
pub fn create(folder: &Path, text: &str) -> io::Result<JobFile> {
    loop {
        let mut file = tempfile::Builder::new()
            .prefix(TEMPORARY_PREFIX)
            .suffix(&format!("{}{SUFFIX}", held::MARK))
            .rand_bytes(10)
            .make_in(folder, held::create)?;
        file.as_file_mut().write_all(text.as_bytes())?;
        // Another process may have removed it before it was locked.
        if file.path().exists() {
            return Ok(JobFile { _file: file });
        }
    }
}

/// The texts of the job files of other living processes in `folder`.
pub fn of_others(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let is_job = |name: &str| name.starts_with(TEMPORARY_PREFIX) && name.ends_with(SUFFIX);
    let names = entries
        .flatten()
        .filter(|entry| entry.file_name().to_str().is_some_and(is_job))
        // Opening anything but a file may wait for ever.
        .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
    let living = names.filter(|entry| matches!(held::take(&entry.path()), Ok(None)));
    living
        .filter_map(|entry| fs::read_to_string(entry.path()).ok())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_job_at_a_time_passes_the_gate_and_leaves_nothing() {
        let home = tempfile::tempdir().unwrap();
        let count = home.path().join("count");
        fs::write(&count, "0").unwrap();
        thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..50 {
                        let _gate = FolderGate::close(home.path(), None);
                        let seen: u32 = fs::read_to_string(&count).unwrap().parse().unwrap();
                        fs::write(&count, (seen + 1).to_string()).unwrap();
                    }
                });
            }
        });
        assert_eq!(fs::read_to_string(&count).unwrap(), "400");
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_cancelled_job_goes_on_without_a_lock_that_another_program_holds() {
        let home = tempfile::tempdir().unwrap();
        let gate = FolderGate::close(home.path(), None);
        let cancel = Cancel::default();
        cancel.cancel();
        let other = FolderGate::close(home.path(), Some(&cancel));
        assert!(gate.file.is_some() && other.file.is_none());
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_no_job() {
        let home = tempfile::tempdir().unwrap();
        let name = home.path().join(format!("{TEMPORARY_PREFIX}x{SUFFIX}"));
        let made = std::process::Command::new("mkfifo").arg(name).status().unwrap();
        assert!(made.success());
        assert!(of_others(home.path()).is_empty());
    }

    #[test]
    fn a_gate_that_a_killed_job_has_left_and_a_folder_that_is_missing_keep_nobody_out() {
        let home = tempfile::tempdir().unwrap();
        let name = format!("{TEMPORARY_PREFIX}gate{TEMPORARY_SUFFIX}");
        fs::write(home.path().join(&name), "").unwrap();
        drop(FolderGate::close(home.path(), None));
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 0);
        drop(FolderGate::close(&home.path().join("missing"), None));
        fs::create_dir(home.path().join(&name)).unwrap();
        drop(FolderGate::close(home.path(), None));
    }
}
