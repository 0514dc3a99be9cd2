//! Files that are whole or absent, whenever the process or the machine stops.
//!
//! The bytes go to a hidden temporary in the target's folder, onto the disk, and then under the target's name; the folder is
//! made durable last. A file that was there stays as it is until the new one is complete. Permissions are those that any new file
//! gets under the process's umask.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
};

use tempfile::NamedTempFile;

use super::{EncodeError, OutputError};

/// Temporaries begin with this; one that is left over is from a process that was killed.
pub const TEMPORARY_PREFIX: &str = ".batch-render-";

const BUFFER: usize = 1 << 18;

/// Makes `path` the file that `encode` writes, and the folders it lies in. On an error the old file stays and the temporary is
/// removed.
pub fn write<T>(path: &Path, encode: impl FnOnce(&mut dyn Write) -> Result<T, EncodeError>) -> Result<T, OutputError> {
    let folder = folder_of(path);
    let file = create(path, &folder).map_err(|source| OutputError::Create {
        source: plain(source),
        path: path.to_owned(),
    })?;
    let failed = |source| OutputError::Write {
        source: plain(source),
        path: path.to_owned(),
    };
    let mut out = BufWriter::with_capacity(BUFFER, file.as_file());
    let written = encode(&mut out).map_err(|error| match error {
        EncodeError::Io(source) => failed(source),
        EncodeError::Unfit(reason) => OutputError::Encode {
            reason,
            path: path.to_owned(),
        },
    })?;
    out.into_inner().map_err(|e| failed(e.into_error()))?;
    file.as_file().sync_all().map_err(failed)?;
    file.persist(path).map_err(|e| failed(e.error))?;
    sync_folder(&folder).map_err(failed)?;
    Ok(written)
}

/// Finds out whether `path` can be made, before there is anything to write: makes its folders and a temporary there.
pub fn check(path: &Path) -> Result<(), OutputError> {
    create(path, &folder_of(path))
        .map(drop)
        .map_err(|source| OutputError::Create {
            source,
            path: path.to_owned(),
        })
}

/// The error without the name of the temporary that tempfile adds to it: the file that was wanted is what counts.
fn plain(error: io::Error) -> io::Error {
    match error.get_ref() {
        Some(_) => error.kind().into(),
        None => error,
    }
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn create(path: &Path, folder: &Path) -> io::Result<NamedTempFile<File>> {
    if path.is_dir() {
        // Found now rather than by the rename, after the work.
        return Err(io::ErrorKind::IsADirectory.into());
    }
    fs::create_dir_all(folder)?;
    // `make_in` leaves opening to us: a plain `open`, where tempfile's own would keep the file from everyone else.
    tempfile::Builder::new()
        .prefix(TEMPORARY_PREFIX)
        .suffix(".tmp")
        .rand_bytes(10)
        .make_in(folder, |path| {
            OpenOptions::new().write(true).create_new(true).open(path)
        })
}

/// Makes the new name durable, where folders can be synchronised: on Unix, but not on every network file system.
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
            let failed = write(&home.path().join(path), |_| Ok(()));
            assert!(matches!(failed, Err(OutputError::Create { .. })), "{path}");
        }
        assert_eq!(names(home.path()), ["file", "folder.exr"]);
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
