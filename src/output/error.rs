//! Why a file was not written.

use std::{
    io,
    path::{Path, PathBuf},
};

/// Why a file was not written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The file cannot be created.
    #[error("cannot create output: {source}: {}", path.display())]
    Create { source: io::Error, path: PathBuf },
    /// Writing failed.
    #[error("cannot write output: {source}: {}", path.display())]
    Write { source: io::Error, path: PathBuf },
    /// The format cannot hold such an image.
    #[error("cannot encode output: {reason}: {}", path.display())]
    Encode { reason: String, path: PathBuf },
}

impl OutputError {
    /// Whether the disk is full or read-only, so that all other frames would fail too.
    pub fn ends_the_job(&self) -> bool {
        use io::ErrorKind::{QuotaExceeded, ReadOnlyFilesystem, StorageFull};
        match self {
            Self::Create { source, .. } | Self::Write { source, .. } => {
                matches!(source.kind(), StorageFull | QuotaExceeded | ReadOnlyFilesystem)
            }
            Self::Encode { .. } => false,
        }
    }

    /// The file that was to be written.
    pub fn path(&self) -> &Path {
        match self {
            Self::Create { path, .. } | Self::Write { path, .. } | Self::Encode { path, .. } => path,
        }
    }

    /// Whether another attempt may succeed, as after a short failure of a network.
    pub fn may_pass(&self) -> bool {
        match self {
            Self::Create { source, .. } | Self::Write { source, .. } => {
                source.kind() != io::ErrorKind::FileTooLarge && !self.ends_the_job()
            }
            Self::Encode { .. } => false,
        }
    }
}
