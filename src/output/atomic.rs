//! Atomic files: whole or absent, whenever the process or the machine stops.
//!
//! The bytes are written to a hidden temporary file in the target's folder, synchronised to disk, and renamed to the target; the
//! folder is synchronised last. Several files may go through these steps together ([`put`]). An existing file stays unchanged until
//! then. The new file has the permissions of the process's umask. A symbolic link is followed: the file is replaced, not the link.
//!
//! A temporary file is held (see `held`) as long as its process lives. Another one was left by a killed
//! process, and [`check`] removes it.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, BufWriter, Seek, Write},
    panic::resume_unwind,
    path::{Path, PathBuf},
    thread::{self, Builder},
    time::{Duration, Instant},
};

use tempfile::NamedTempFile;

use super::{EncodeError, FileNames, Obstacle, OutputError, held};

/// The prefix and the suffix of temporary files.
pub const TEMPORARY_PREFIX: &str = ".batch-render-";
pub const TEMPORARY_SUFFIX: &str = ".tmp";

const BUFFER: usize = 1 << 18;

/// A new file, which is written from its beginning.
pub trait NewFile: Write + Seek {}

impl<T: Write + Seek> NewFile for T {}

/// The most threads that wait for the disk. The system makes files durable together that are synchronised at the same time.
const MAX_SYNC_THREADS: usize = 16;

/// The time for which a file is waited for that another program has open, as Windows then refuses to replace it, and the
/// interval of attempts.
const PATIENCE: Duration = Duration::from_secs(2);
const POLL: Duration = Duration::from_millis(50);

/// Writes the output of `encode` to `path`, in an existing folder. On an error an old file stays,
/// and the temporary file is removed.
pub fn write<T>(
    path: &Path,
    encode: impl FnOnce(&mut dyn NewFile) -> Result<T, EncodeError>,
) -> Result<T, OutputError> {
    let (file, written) = PendingFile::new(path, encode)?;
    put([file].into())?;
    Ok(written)
}

/// Writes contents to files in existing folders. On an error of any of them all old files stay.
pub fn write_together<C: AsRef<[u8]>>(files: &[(PathBuf, C)]) -> Result<(), OutputError> {
    let pending = |(path, content): &(PathBuf, C)| {
        let pending = PendingFile::new(path, |out| Ok(out.write_all(content.as_ref())?));
        pending.map(|(pending, ())| pending)
    };
    put(files.iter().map(pending).collect::<Result<_, _>>()?)
}

/// A file that is written under a temporary name, which goes away with it, until [`put`] gives it its own.
pub struct PendingFile {
    file: NamedTempFile<File>,
    target: PathBuf,
    /// The path that was asked for.
    path: PathBuf,
}

impl PendingFile {
    /// Writes the output of `encode` to a temporary file beside `path`, in an existing folder.
    pub fn new<T>(
        path: &Path,
        encode: impl FnOnce(&mut dyn NewFile) -> Result<T, EncodeError>,
    ) -> Result<(Self, T), OutputError> {
        let failed = |source| OutputError::Write {
            source: plain(source),
            path: path.to_owned(),
        };
        let (target, file) = create(path).map_err(|source| not_created(source, path))?;
        let mut out = BufWriter::with_capacity(BUFFER, file.as_file());
        let written = encode(&mut out).map_err(|error| match error {
            EncodeError::Io(source) => failed(source),
            EncodeError::Unfit(reason) => OutputError::Encode {
                reason,
                path: path.to_owned(),
            },
        })?;
        out.into_inner().map_err(|e| failed(e.into_error()))?;
        let path = path.to_owned();
        Ok((Self { file, target, path }, written))
    }

    fn sync(&self) -> Result<(), OutputError> {
        self.file.as_file().sync_all().map_err(|source| self.failed(source))
    }

    fn failed(&self, source: io::Error) -> OutputError {
        OutputError::Write {
            source: plain(source),
            path: self.path.clone(),
        }
    }

    fn rename(mut self) -> Result<(), OutputError> {
        let start = Instant::now();
        loop {
            match fs::rename(self.file.path(), &self.target) {
                Ok(()) => {
                    self.file.disable_cleanup(true);
                    return Ok(());
                }
                Err(error) if is_kept_open(&error, &self.target) => {
                    if start.elapsed() > PATIENCE {
                        let message = "another program has the file open";
                        return Err(self.failed(io::Error::new(io::ErrorKind::ResourceBusy, message)));
                    }
                    thread::sleep(POLL);
                }
                Err(error) if error.kind() == io::ErrorKind::NotFound && folder_of(&self.target).is_dir() => {
                    // A machine that sees no locks of this one has taken it for that of a killed process.
                    let message = "another machine has removed the temporary file";
                    return Err(self.failed(io::Error::new(io::ErrorKind::ResourceBusy, message)));
                }
                Err(error) => return Err(self.failed(error)),
            }
        }
    }
}

/// Makes files durable and gives them their names, in their order. All of them are whole on disk before the first has its name.
///
/// # Errors
/// One of them cannot be written. Those before it may have their names; those after it are removed.
pub fn put(files: Vec<PendingFile>) -> Result<(), OutputError> {
    let share = files.len().div_ceil(MAX_SYNC_THREADS).max(1);
    let sync = |files: &[PendingFile]| files.iter().try_for_each(PendingFile::sync);
    thread::scope(|scope| {
        let (own, others) = files.split_at(share.min(files.len()));
        let others: Vec<_> = others
            .chunks(share)
            .map(|files| (files, Builder::new().spawn_scoped(scope, move || sync(files))))
            .collect();
        let own = sync(own);
        // Where there are no more threads, this one waits for the disk.
        let of_others = others.into_iter().map(|(files, thread)| match thread {
            Ok(thread) => thread.join().unwrap_or_else(|panic| resume_unwind(panic)),
            Err(_) => sync(files),
        });
        [own]
            .into_iter()
            .chain(of_others.collect::<Vec<_>>())
            .collect::<Result<(), _>>()
    })?;
    let mut folders: Vec<(PathBuf, PathBuf)> = Vec::new();
    for file in files {
        let (folder, path) = (folder_of(&file.target), file.path.clone());
        file.rename()?;
        if folders.iter().all(|(known, _)| *known != folder) {
            folders.push((folder, path));
        }
    }
    folders.into_iter().try_for_each(|(folder, path)| {
        sync_folder(&folder).map_err(|source| OutputError::Write {
            source: plain(source),
            path,
        })
    })
}

/// Whether a file cannot be replaced, by this error, because another program has it open.
fn is_kept_open(error: &io::Error, target: &Path) -> bool {
    // Windows denies the access to a file that others may read and write, but not remove.
    let is_denied = cfg!(windows) && error.kind() == io::ErrorKind::PermissionDenied;
    held::is_in_use(error) || is_denied && check_permissions(target).is_ok()
}

/// Checks whether `path` can be written: makes its folders and a temporary file, and removes those of killed processes.
pub fn check(path: &Path) -> Result<(), OutputError> {
    let attempt = || {
        fs::create_dir_all(folder_of(path))?;
        let (target, _file) = create(path)?;
        held::remove_abandoned(&folder_of(&target), TEMPORARY_PREFIX, TEMPORARY_SUFFIX);
        Ok(())
    };
    attempt().map_err(|source| not_created(source, path))
}

/// Checks whether what is at `path`, if anything, may be replaced. Makes nothing.
///
/// # Errors
/// It may not, or nothing can be created in its folder.
pub fn check_old(path: &Path) -> Result<(), OutputError> {
    let checked = target_of(path).and_then(|target| check_permissions(&target));
    checked.map_err(|source| not_created(source, path))
}

/// The error of a file that cannot be created: of its folder, unless what is at its path explains it.
fn not_created(source: io::Error, path: &Path) -> OutputError {
    let folder = folder_of(path);
    let may_be_replaced = |target: PathBuf| folder_of(&target) == folder && check_file(&target).is_ok();
    OutputError::Create {
        source: folder_problem(plain(source), &folder),
        path: path.to_owned(),
        obstacle: match target_of(path).is_ok_and(may_be_replaced) {
            true => Obstacle::Folder,
            false => Obstacle::File,
        },
    }
}

/// Fails if the system does not allow a file of this name.
fn check_name(path: &Path) -> io::Result<()> {
    match FileNames::HERE.fault(path) {
        Some(fault) => Err(io::Error::new(io::ErrorKind::InvalidInput, fault)),
        None => Ok(()),
    }
}

/// The error of a folder that cannot be made or used, which says so where a file is in its place or its name is not allowed.
pub fn folder_problem(error: io::Error, folder: &Path) -> io::Error {
    if let Err(fault) = check_name(folder) {
        return fault;
    }
    let file = folder
        .ancestors()
        .find(|path| fs::metadata(path).is_ok_and(|found| !found.is_dir()));
    match (error.kind(), file) {
        (io::ErrorKind::AlreadyExists | io::ErrorKind::NotADirectory, Some(file)) => {
            let message = format!("{} is a file, and a folder must be there", file.display());
            io::Error::new(io::ErrorKind::NotADirectory, message)
        }
        _ => error,
    }
}

/// Removes the temporary files of killed processes beside `path`.
pub fn sweep(path: &Path) {
    if let Ok(target) = target_of(path) {
        held::remove_abandoned(&folder_of(&target), TEMPORARY_PREFIX, TEMPORARY_SUFFIX);
    }
}

/// Fails if anything but a regular file is at `path`.
pub fn check_kind(path: &Path) -> Result<(), OutputError> {
    match fs::metadata(path) {
        Ok(old) => check_is_file(&old).map_err(|source| OutputError::Create {
            source,
            path: path.to_owned(),
            obstacle: Obstacle::File,
        }),
        // A missing or unreadable path is reported when it is written.
        Err(_) => Ok(()),
    }
}

fn check_is_file(found: &fs::Metadata) -> io::Result<()> {
    if found.is_dir() {
        Err(io::ErrorKind::IsADirectory.into())
    } else if !found.is_file() {
        Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file"))
    } else {
        Ok(())
    }
}

/// Removes the name of the temporary file, which tempfile adds, from an error.
fn plain(error: io::Error) -> io::Error {
    // Only this module's own errors are of these kinds.
    let is_own = matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::ResourceBusy);
    match error.get_ref() {
        Some(_) if !is_own => error.kind().into(),
        _ => error,
    }
}

/// The folder that `path` is in.
pub fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Follows symbolic links at `path`, also to a file that does not exist yet.
///
/// # Errors
/// There are too many, or the system does not allow such a name.
pub fn target_of(path: &Path) -> io::Result<PathBuf> {
    const MOST_LINKS: usize = 40;
    check_name(path)?;
    let mut target = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::symlink_metadata(&target) {
            Ok(found) if found.is_symlink() => target = folder_of(&target).join(fs::read_link(&target)?),
            _ => return Ok(target),
        }
    }
    Err(io::Error::new(io::ErrorKind::InvalidInput, "too many symbolic links"))
}

/// Checks whether the process may replace `target`. A read-only file or folder is respected even for an administrator, to whom
/// the system grants everything.
fn check_permissions(target: &Path) -> io::Result<()> {
    check_file(target)?;
    // On Windows a folder's read-only attribute does not concern its files.
    if cfg!(unix) && fs::metadata(folder_of(target))?.permissions().readonly() {
        return Err(io::ErrorKind::PermissionDenied.into());
    }
    Ok(())
}

/// Checks whether what is at `target`, if anything, is a file that the process may write.
fn check_file(target: &Path) -> io::Result<()> {
    use io::ErrorKind::{NotADirectory, NotFound};
    match fs::metadata(target) {
        Ok(old) => {
            check_is_file(&old)?;
            if old.permissions().readonly() {
                return Err(io::ErrorKind::PermissionDenied.into());
            }
            // Opening the file tests the permission and changes nothing.
            match OpenOptions::new().write(true).open(target) {
                // It may be closed by the time at which it is replaced.
                Err(error) if held::is_in_use(&error) => {}
                opened => drop(opened?),
            }
            Ok(())
        }
        Err(error) if matches!(error.kind(), NotFound | NotADirectory) => Ok(()),
        Err(error) => Err(error),
    }
}

/// Makes a temporary file beside the target of `path`. Returns the target's path and the held temporary file.
fn create(path: &Path) -> io::Result<(PathBuf, NamedTempFile<File>)> {
    let target = target_of(path)?;
    check_permissions(&target)?;
    let folder = folder_of(&target);
    loop {
        // A plain `open`: tempfile's own would make the file private to the user.
        let file = tempfile::Builder::new()
            .prefix(TEMPORARY_PREFIX)
            .suffix(&format!("{}{TEMPORARY_SUFFIX}", held::MARK))
            .rand_bytes(10)
            .make_in(&folder, held::create)?;
        // Another process may have removed it before it was locked.
        if file.path().exists() {
            return Ok((target, file));
        }
    }
}

/// Synchronises a folder, so that a new name is durable. Works on Unix, except on some network file systems.
fn sync_folder(folder: &Path) -> io::Result<()> {
    use io::ErrorKind::{InvalidInput, Unsupported};
    if !cfg!(unix) {
        return Ok(());
    }
    match File::open(folder)?.sync_all() {
        Err(error) if matches!(error.kind(), InvalidInput | Unsupported) => Ok(()),
        result => result,
    }
}

#[cfg(test)]
mod tests;
