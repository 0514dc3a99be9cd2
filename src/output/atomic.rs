//! Atomic files: whole or absent, whenever the process or the machine stops.
//!
//! The bytes are written to a hidden temporary file in the target's folder, synchronised to disk, and renamed to the target; the
//! folder is synchronised last. Several files may go through these steps together ([`put`]). An existing file stays unchanged until then. The new file has the permissions of the process's
//! umask. A symbolic link is followed: the file is replaced, not the link.
//!
//! A temporary file is held (see `held`) as long as its process lives. Another one was left by a killed process, and [`check`] removes it.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, BufWriter, Seek, Write},
    panic::resume_unwind,
    path::{Path, PathBuf},
    thread::{self, Builder},
    time::{Duration, Instant},
};

use tempfile::NamedTempFile;

use super::{EncodeError, OutputError, held};

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

/// Writes the output of `encode` to `path`, in an existing folder. On an error an old file stays, and the temporary file is removed.
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
        let (target, file) = create(path).map_err(|source| OutputError::Create {
            source: folder_problem(plain(source), &folder_of(path)),
            path: path.to_owned(),
        })?;
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
                        return Err(self.failed(io::Error::new(io::ErrorKind::InvalidInput, message)));
                    }
                    thread::sleep(POLL);
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
    attempt().map_err(|source| OutputError::Create {
        source: folder_problem(plain(source), &folder_of(path)),
        path: path.to_owned(),
    })
}

/// The error of a folder that cannot be made or used, which says so where a file is in its place.
pub fn folder_problem(error: io::Error, folder: &Path) -> io::Error {
    let file = folder
        .ancestors()
        .find(|path| fs::metadata(path).is_ok_and(|found| !found.is_dir()));
    match (error.kind(), file) {
        (io::ErrorKind::AlreadyExists | io::ErrorKind::NotADirectory, Some(file)) => {
            let message = format!("{} is a file, and a folder must be there", file.display());
            io::Error::new(io::ErrorKind::InvalidInput, message)
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
    match error.get_ref() {
        // Only this module's own errors are of that kind.
        Some(_) if error.kind() != io::ErrorKind::InvalidInput => error.kind().into(),
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
pub fn target_of(path: &Path) -> io::Result<PathBuf> {
    const MOST_LINKS: usize = 40;
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
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    // On Windows a folder's read-only attribute does not concern its files.
    if cfg!(unix) && fs::metadata(folder_of(target))?.permissions().readonly() {
        return Err(io::ErrorKind::PermissionDenied.into());
    }
    Ok(())
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
            .suffix(TEMPORARY_SUFFIX)
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
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn folders_are_made_and_nothing_else_is_left() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("a/b/frame.exr");
        check(&path).unwrap();
        let seven = write(&path, |out| {
            out.write_all(b"whole")?;
            Ok(7)
        });
        assert_eq!(seven.unwrap(), 7);
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(names(path.parent().unwrap()), ["frame.exr"]);
    }

    #[test]
    fn an_error_in_the_middle_keeps_the_old_file_and_leaves_no_temporary() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("frame.exr");
        fs::write(&path, b"old").unwrap();
        for unfit in [true, false] {
            let failed = write(&path, |out| -> Result<(), _> {
                out.write_all(&[1; 1 << 20])?;
                assert_eq!(names(home.path()).len(), 2);
                Err(match unfit {
                    true => EncodeError::Unfit("too wide".into()),
                    false => io::Error::from(io::ErrorKind::StorageFull).into(),
                })
            });
            let error = failed.unwrap_err();
            assert_eq!(error.ends_the_job(), !unfit);
            assert_eq!(unfit, matches!(error, OutputError::Encode { .. }));
            assert!(error.to_string().ends_with("frame.exr"));
            assert_eq!(fs::read(&path).unwrap(), b"old");
            assert_eq!(names(home.path()), ["frame.exr"]);
        }
    }

    #[test]
    fn files_that_are_written_together_are_all_new_or_all_old() {
        let home = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| (home.path().join(name), text.to_owned());
        let old = [file("a", "old"), file("b", "old")];
        write_together(&old).unwrap();
        assert!(write_together(&[file("a", "new"), file("missing/c", "new"), file("b", "new")]).is_err());
        let contents = |text: &str| old.iter().all(|(path, _)| fs::read(path).unwrap() == text.as_bytes());
        assert!(contents("old"));
        write_together(&[file("a", "new"), file("b", "new")]).unwrap();
        assert!(contents("new"));
        assert_eq!(names(home.path()), ["a", "b"]);
    }

    #[test]
    fn many_files_of_several_folders_are_put_together_and_those_that_are_not_put_leave_nothing() {
        let home = tempfile::tempdir().unwrap();
        let path = |i: usize| {
            home.path()
                .join(if i.is_multiple_of(2) { "a" } else { "b" })
                .join(i.to_string())
        };
        check(&path(0)).unwrap();
        check(&path(1)).unwrap();
        let pending = |i: usize| PendingFile::new(&path(i), |out| Ok(write!(out, "{i}")?)).unwrap().0;
        let files: Vec<PendingFile> = (0..101).map(pending).collect();
        assert!(!path(100).exists());
        put(files).unwrap();
        drop((0..4).map(|i| pending(200 + i)).collect::<Vec<_>>());
        assert!((0..101).all(|i| fs::read(path(i)).unwrap() == i.to_string().as_bytes()));
        assert_eq!(["a", "b"].map(|name| names(&home.path().join(name)).len()), [51, 50]);
    }

    #[test]
    fn a_panic_in_the_middle_leaves_no_temporary() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("frame.exr");
        let attempt = std::panic::catch_unwind(|| write(&path, |_| -> Result<(), _> { panic!("on purpose") }));
        assert!(attempt.is_err());
        assert!(names(home.path()).is_empty());
    }

    #[test]
    fn a_place_where_nothing_can_be_made_is_a_create_error() {
        let home = tempfile::tempdir().unwrap();
        fs::write(home.path().join("file"), b"").unwrap();
        fs::create_dir(home.path().join("folder.exr")).unwrap();
        for path in ["file/frame.exr", "folder.exr"] {
            let path = home.path().join(path);
            for failed in [check(&path), write(&path, |_| Ok(()))] {
                assert!(matches!(failed, Err(OutputError::Create { .. })), "{}", path.display());
            }
        }
        assert_eq!(names(home.path()), ["file", "folder.exr"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed_and_stays_a_link() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("store");
        fs::create_dir(&folder).unwrap();
        let link = home.path().join("frame.exr");
        std::os::unix::fs::symlink("store/real.exr", &link).unwrap();
        // The link is dangling at first, then it leads to an old file.
        for content in [b"one", b"two"] {
            write(&link, |out| Ok(out.write_all(content)?)).unwrap();
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
            assert_eq!(fs::read(folder.join("real.exr")).unwrap(), content);
        }
        assert_eq!(names(&folder), ["real.exr"]);

        let circle = home.path().join("circle.exr");
        std::os::unix::fs::symlink("circle.exr", &circle).unwrap();
        assert!(matches!(check(&circle), Err(OutputError::Create { .. })));
    }

    #[cfg(unix)]
    #[test]
    fn nothing_without_write_permission_is_replaced() {
        use std::os::unix::fs::PermissionsExt;
        let home = tempfile::tempdir().unwrap();
        let set = |path: &Path, mode| fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
        let file = home.path().join("file.exr");
        fs::write(&file, b"old").unwrap();
        set(&file, 0o444);
        let folder = home.path().join("folder");
        fs::create_dir(&folder).unwrap();
        set(&folder, 0o555);
        for path in [&file, &folder.join("new.exr")] {
            for failed in [check(path), write(path, |_| Ok(()))] {
                assert!(matches!(failed, Err(OutputError::Create { .. })), "{}", path.display());
            }
        }
        assert_eq!(fs::read(&file).unwrap(), b"old");
        set(&folder, 0o755);
    }

    #[test]
    fn temporaries_of_the_dead_are_removed_and_those_of_the_living_stay() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("frame.exr");
        fs::write(home.path().join(".batch-render-0123456789.tmp"), b"half").unwrap();
        fs::write(home.path().join(".batch-render-notes"), b"not ours").unwrap();
        write(&path, |_| {
            check(&home.path().join("other.exr")).unwrap();
            let left = names(home.path());
            assert_eq!(left.len(), 2, "{left:?}");
            Ok(())
        })
        .unwrap();
        assert_eq!(names(home.path()), [".batch-render-notes", "frame.exr"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_file_has_the_permissions_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let home = tempfile::tempdir().unwrap();
        let (plain, ours) = (home.path().join("plain"), home.path().join("ours"));
        fs::write(&plain, b"").unwrap();
        write(&ours, |_| Ok(())).unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
