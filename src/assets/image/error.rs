//! Why a picture was not loaded.

use std::{
    io,
    path::{Path, PathBuf},
};

use crate::assets::{OverBudget, files::is_refused};

/// Why a picture was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    #[error("cannot read image: {source}: {}", path.display())]
    Read { source: io::Error, path: PathBuf },
    #[error("unknown image format (expected one of `png`, `jpeg`, `bmp`, `tga`, `webp`, `hdr`, `exr`): {}", path.display())]
    Unknown { path: PathBuf },
    #[error("broken image: {cause}: {}", path.display())]
    Broken { cause: String, path: PathBuf },
    #[error("{}: {}", unfit(*width, *height), path.display())]
    Size { width: u64, height: u64, path: PathBuf },
    #[error("{cause}: {}", path.display())]
    Memory { cause: OverBudget, path: PathBuf },
}

fn unfit(width: u64, height: u64) -> String {
    if width == 0 || height == 0 {
        format!("the image has no pixels, its size is {width} x {height}")
    } else {
        format!("an image of {width} x {height} pixels is too large")
    }
}

impl ImageError {
    /// The file.
    pub fn path(&self) -> &Path {
        let (Self::Read { path, .. }
        | Self::Unknown { path }
        | Self::Broken { path, .. }
        | Self::Size { path, .. }
        | Self::Memory { path, .. }) = self;
        path
    }

    /// Whether the file could not be read, rather than decoded.
    pub fn is_missing(&self) -> bool {
        matches!(self, Self::Read { source, .. } if !is_refused(source))
    }
}

/// An error in the bytes of an image file.
#[derive(Debug)]
pub(super) enum ImageProblem {
    Unknown,
    Broken(String),
    Size { width: u64, height: u64 },
    Memory(OverBudget),
}

impl From<OverBudget> for ImageProblem {
    fn from(over: OverBudget) -> Self {
        Self::Memory(over)
    }
}

impl ImageProblem {
    pub fn broken(cause: impl ToString) -> Self {
        Self::Broken(cause.to_string().trim_end().to_owned())
    }

    pub fn at(self, path: &Path) -> ImageError {
        let path = path.to_owned();
        match self {
            Self::Unknown => ImageError::Unknown { path },
            Self::Broken(cause) => ImageError::Broken { cause, path },
            Self::Size { width, height } => ImageError::Size { width, height, path },
            Self::Memory(cause) => ImageError::Memory { cause, path },
        }
    }
}

impl From<::image::ImageError> for ImageProblem {
    fn from(error: ::image::ImageError) -> Self {
        Self::broken(error)
    }
}
