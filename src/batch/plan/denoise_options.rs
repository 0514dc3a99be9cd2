//! The settings of denoising.

use std::path::PathBuf;

use crate::output::{Exr, FilePattern, FilePatternError, Format as _};

/// The settings of the denoiser.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DenoiseOptions {
    /// Frames on each side that help.
    pub temporal: u32,
    pub filter: FilterKind,
}

impl DenoiseOptions {
    /// Whether one of these frames helps the other.
    pub fn reaches(&self, frame: i32, other: i32) -> bool {
        frame.abs_diff(other) <= self.temporal
    }
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

/// The steps of a job that denoises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DenoiseSteps {
    #[default]
    Both,
    /// The frames are rendered, and stay noisy.
    Render,
    /// The frames, which are there, are denoised.
    Denoise,
}

/// The denoising of a job.
#[derive(Clone, Debug)]
pub struct DenoisePlan {
    pub options: DenoiseOptions,
    pub steps: DenoiseSteps,
    /// The rendered files.
    pub noisy: FilePattern,
    /// The files that are made of them.
    pub clean: Vec<FilePattern>,
}

/// The folder of the rendered files, beside those of the job.
const NOISY_FOLDER: &str = "noisy";

/// The rendered files that become these ones: EXR files, named as the first ones that are EXR, else as the first ones.
pub(in crate::batch) fn noisy(clean: &[FilePattern]) -> Result<FilePattern, FilePatternError> {
    let is_exr = |pattern: &&FilePattern| pattern.format().name() == Exr.name();
    let named = clean.iter().find(is_exr).or(clean.first());
    let pattern = named.expect("a job has files").in_folder(NOISY_FOLDER)?;
    if is_exr(&&pattern) {
        return Ok(pattern);
    }
    let text = pattern.as_str();
    FilePattern::parse(&format!(
        "{}{}",
        &text[..text.len() - pattern.format().name().len()],
        Exr.name()
    ))
}
