//! Errors of writing files, and whether they also concern other files.

use std::{
    io,
    path::{Path, PathBuf},
};

/// What keeps a file from being created.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// What is at its path, such as a folder.
    File,
    /// Its folder, in which no other file can be created either.
    Folder,
}

/// An error that kept a file from being written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The file cannot be created.
    #[error("cannot create output: {source}: {}", path.display())]
    Create {
        source: io::Error,
        path: PathBuf,
        obstacle: Obstacle,
    },
    /// Writing failed.
    #[error("cannot write output: {source}: {}", path.display())]
    Write { source: io::Error, path: PathBuf },
    /// The format cannot hold such an image.
    #[error("cannot encode output: {reason}: {}", path.display())]
    Encode { reason: String, path: PathBuf },
}

impl OutputError {
    /// Whether the disk is full or read-only.
    pub fn is_of_disk(&self) -> bool {
        use io::ErrorKind::{QuotaExceeded, ReadOnlyFilesystem, StorageFull};
        match self {
            Self::Create { source, .. } | Self::Write { source, .. } => {
                matches!(source.kind(), StorageFull | QuotaExceeded | ReadOnlyFilesystem)
            }
            Self::Encode { .. } => false,
        }
    }

    /// Whether all other frames would fail too: the disk is full or read-only, or no file can be created in the folder and another
    /// attempt would not help.
    pub fn ends_the_job(&self) -> bool {
        let is_of_folder = matches!(
            self,
            Self::Create {
                obstacle: Obstacle::Folder,
                ..
            }
        );
        self.is_of_disk() || is_of_folder && !self.may_pass()
    }

    /// Whether what is at the path of the file alone keeps it from being created.
    pub fn is_of_file(&self) -> bool {
        let obstacle = match self {
            Self::Create { obstacle, .. } => Some(*obstacle),
            Self::Write { .. } | Self::Encode { .. } => None,
        };
        obstacle == Some(Obstacle::File)
    }

    /// The file that was to be written.
    pub fn path(&self) -> &Path {
        match self {
            Self::Create { path, .. } | Self::Write { path, .. } | Self::Encode { path, .. } => path,
        }
    }

    /// Whether another attempt may succeed, as after a short failure of a network.
    pub fn may_pass(&self) -> bool {
        use io::ErrorKind::{FileTooLarge, InvalidInput, IsADirectory, NotADirectory, NotFound, PermissionDenied};
        match self {
            Self::Create { source, .. } | Self::Write { source, .. } => {
                let lasting = [
                    FileTooLarge,
                    InvalidInput,
                    IsADirectory,
                    NotADirectory,
                    NotFound,
                    PermissionDenied,
                ];
                !lasting.contains(&source.kind()) && !self.is_of_disk()
            }
            Self::Encode { .. } => false,
        }
    }
}
