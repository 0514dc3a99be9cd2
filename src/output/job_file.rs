//! Job files: a running job lists the files that it writes, so that two jobs do not write the same file.
//!
//! A job file is locked as long as its process lives, and removed at the end or by the next job. It is a hidden temporary file in
//! the folder of the pictures, see [`atomic`](super::atomic).

use std::{
    fs::{self, File, OpenOptions, TryLockError},
    io::{self, Write},
    path::Path,
};

use tempfile::NamedTempFile;

use super::atomic::TEMPORARY_PREFIX;

const SUFFIX: &str = ".job.tmp";

/// A job's own file, removed on drop.
#[derive(Debug)]
pub struct JobFile {
    _file: NamedTempFile<File>,
}

/// A lock on the job files of a folder. It does nothing on systems that cannot lock folders.
#[derive(Debug)]
pub struct FolderGate {
    _folder: Option<File>,
}

impl FolderGate {
    pub fn close(folder: &Path) -> Self {
        let folder = File::open(folder).ok().filter(|file| file.lock().is_ok());
        Self { _folder: folder }
    }
}

/// This process and its machine, as text.
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
            .suffix(SUFFIX)
            .rand_bytes(10)
            .make_in(folder, |path| {
                OpenOptions::new().write(true).create_new(true).open(path)
            })?;
        // Without locks it looks like the file of a dead job.
        let _ = file.as_file().lock();
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
        .filter(|entry| entry.file_name().to_str().is_some_and(is_job));
    let living = names.filter(|entry| {
        let file = OpenOptions::new().write(true).open(entry.path());
        file.is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
    });
    living
        .filter_map(|entry| fs::read_to_string(entry.path()).ok())
        .collect()
}
