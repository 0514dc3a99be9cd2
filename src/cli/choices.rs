//! Flags with a fixed choice of values.

use batch_render::{
    assets::store::MissingAssets,
    batch::{DenoiseSteps, IfBusy, PartBase},
};
use clap::ValueEnum;

/// The number of the first part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PartBaseKind {
    #[value(name = "0")]
    Zero,
    #[default]
    #[value(name = "1")]
    One,
}

impl From<PartBaseKind> for PartBase {
    fn from(kind: PartBaseKind) -> Self {
        match kind {
            PartBaseKind::Zero => Self::Zero,
            PartBaseKind::One => Self::One,
        }
    }
}

/// The treatment of files that another job is writing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum IfBusyKind {
    /// Wait until it has ended
    #[default]
    Wait,
    /// End with code 75
    Leave,
}

impl From<IfBusyKind> for IfBusy {
    fn from(kind: IfBusyKind) -> Self {
        match kind {
            IfBusyKind::Wait => Self::Wait,
            IfBusyKind::Leave => Self::Leave,
        }
    }
}

/// The filter of the denoiser.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum DenoiserKind {
    /// Non-local means, of this program
    #[default]
    Nlm,
    /// Open Image Denoise, where it is installed
    Oidn,
}

/// The half of a job that denoises.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DenoiseStep {
    /// Render the frames, and leave them noisy
    Render,
    /// Denoise the frames, which are there
    Denoise,
}

impl From<DenoiseStep> for DenoiseSteps {
    fn from(step: DenoiseStep) -> Self {
        match step {
            DenoiseStep::Render => Self::Render,
            DenoiseStep::Denoise => Self::Denoise,
        }
    }
}

/// The treatment of images that are missing or broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MissingKind {
    /// Refuse the scene
    Error,
    /// Show magenta and black squares in its place, with a warning
    Placeholder,
}

impl From<MissingKind> for MissingAssets {
    fn from(kind: MissingKind) -> Self {
        match kind {
            MissingKind::Error => Self::Error,
            MissingKind::Placeholder => Self::Placeholder,
        }
    }
}

/// The display of progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProgressKind {
    /// Bars on a terminal, plain lines elsewhere
    Auto,
    /// One bar for the sequence and one for the frame
    Bar,
    /// One line per frame
    Plain,
    /// One event a line, as JSON
    Json,
    /// The lines that Open Job Description reads
    Openjd,
    /// Nothing
    None,
}
