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
    /// Whether frames whose files are there are to be rendered again.
    pub overwrites: bool,
    /// The frames of the whole job.
    pub frames: FrameRange,
    pub chunk: u32,
}
