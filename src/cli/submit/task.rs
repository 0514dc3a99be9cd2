//! The facts of a job that a farm is told.

use batch_render::batch::FrameRange;

/// The facts of a job that both engines are told.
pub struct Task {
    pub name: String,
    /// The folder in which the program starts, where relative paths begin.
    pub folder: String,
    /// This program.
    pub program: String,
    /// Its arguments, without those that choose frames.
    pub arguments: Vec<String>,
    /// Whether a second step denoises the frames.
    pub denoises: bool,
    /// Whether frames whose files are there are to be rendered again.
    pub overwrites: bool,
    /// The frames of the whole job.
    pub frames: FrameRange,
    pub chunk: u32,
}

/// A step of a job: the frames of the second need those of the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    Render,
    Denoise,
}

impl Task {
    /// The steps of the job, each with the arguments that it has of its own.
    pub fn steps(&self) -> &'static [(Step, &'static [&'static str])] {
        match self.denoises {
            false => &[(Step::Render, &[])],
            true => &[
                (Step::Render, &["--denoise-step", "render"]),
                (Step::Denoise, &["--denoise-step", "denoise"]),
            ],
        }
    }
}
