//! Why a sequence was not denoised.

use std::path::PathBuf;

use crate::native::OidnError;

/// Why a sequence was not denoised.
#[derive(Debug, thiserror::Error)]
pub enum DenoiseError {
    #[error("no file of the sequence is there: {pattern}")]
    NoFiles { pattern: String },
    #[error("there is no such frame: {}", path.display())]
    Missing { path: PathBuf },
    #[error(
        "the sequence has a gap: {} is missing between frames {before} and {after}. Render it, or denoise each frame by itself (--temporal 0)",
        path.display()
    )]
    Gap { path: PathBuf, before: i32, after: i32 },
    #[error("the file was rendered from other inputs or with other settings: render it again: {}", path.display())]
    OtherJob { path: PathBuf },
    #[error("the file is incomplete or altered: {}", path.display())]
    Damaged { path: PathBuf },
    #[error("the file was not written by batch-render: {}", path.display())]
    Foreign { path: PathBuf },
    #[error("{cause}: {}", path.display())]
    Unreadable { path: PathBuf, cause: String },
    #[error("the file has no channel {channel}: render with --aovs denoise: {}", path.display())]
    MissingLayer { channel: String, path: PathBuf },
    #[error("the file has one sample a pixel, and the denoiser compares two halves: render with 2 samples or more: {}", path.display())]
    OneSample { path: PathBuf },
    #[error("the file is denoised already: {}", path.display())]
    Denoised { path: PathBuf },
    #[error("pixel {x}, {y} of {channel} is {value}: {}", path.display())]
    NotFinite {
        x: i32,
        y: i32,
        channel: String,
        value: f32,
        path: PathBuf,
    },
    #[error(transparent)]
    Oidn(#[from] OidnError),
    #[error("the frames have different sizes, crops or layers: {} and {}", first.display(), second.display())]
    Different { first: PathBuf, second: PathBuf },
}
