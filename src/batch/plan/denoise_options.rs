//! The settings of denoising.

use std::path::PathBuf;

use crate::{
    error::Error,
    output::{Exr, FilePattern, Format as _},
};

/// The settings of the denoiser.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DenoiseOptions {
    /// Frames on each side that help.
    pub temporal: u32,
    pub filter: FilterKind,
}

/// The filter that follows the mean over time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum FilterKind {
    /// The program's own.
    #[default]
    NonLocalMeans,
    /// Open Image Denoise, from this library or from where systems have it.
    Oidn { library: Option<PathBuf> },
}

/// The denoising of a job.
#[derive(Clone, Debug)]
pub struct DenoisePlan {
    pub options: DenoiseOptions,
    /// The files before and after.
    pub files: Vec<(FilePattern, FilePattern)>,
}

/// The folder of the files before they are denoised, beside those after.
pub(in crate::batch) const NOISY_FOLDER: &str = "noisy";

/// The EXR files among those of a job, which can be denoised.
///
/// # Errors
/// One is not EXR and was asked for, or none is.
pub(in crate::batch) fn exr_alone(mut patterns: Vec<FilePattern>, are_asked: bool) -> Result<Vec<FilePattern>, Error> {
    let is_exr = |pattern: &FilePattern| pattern.format().name() == Exr.name();
    if let Some(other) = patterns.iter().find(|pattern| are_asked && !is_exr(pattern)) {
        let message = format!(
            "--denoise: denoised frames are EXR files, and {} is none",
            other.as_str()
        );
        return Err(Error::Usage(message));
    }
    patterns.retain(is_exr);
    if patterns.is_empty() {
        let message = "--denoise: denoised frames are EXR files, and the scene's `files` names none (give -o)";
        return Err(Error::Usage(message.to_owned()));
    }
    Ok(patterns)
}
