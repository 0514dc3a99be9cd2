//! Frames that failed: what to say of each, and the exit code.

use std::fmt;

use batch_render::{
    batch::{FrameError, FrameFailure, Summary},
    error::{Blame, Error},
};

use super::replay::Replay;

/// Some frames are not on disk.
#[derive(Debug)]
pub struct FramesFailed {
    count: usize,
    /// Who must act, where it is the same for all frames and no frame succeeded.
    pub blame: Option<Blame>,
}

impl FramesFailed {
    /// An error if a frame of the job failed.
    pub fn check(summary: Summary) -> anyhow::Result<()> {
        let count = summary.failures.len();
        if count == 0 {
            return Ok(());
        }
        let panicked = |f: &&FrameFailure| matches!(f.cause, FrameError::Panic(_));
        let tried = summary.rendered + summary.failures.iter().filter(panicked).count();
        let mut blames = summary.failures.into_iter().map(|failure| blame(failure.cause));
        let first = blames.next().flatten();
        let is_common = count == tried && blames.all(|blame| blame == first);
        let blame = first.filter(|_| is_common);
        Err(anyhow::Error::new(Self { count, blame }))
    }
}

/// Who must act; `None` for a fault of the program.
fn blame(cause: FrameError) -> Option<Blame> {
    match cause {
        FrameError::Panic(_) => None,
        FrameError::Output(error) => Some(Error::Output(error).blame()),
    }
}

impl fmt::Display for FramesFailed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.count {
            1 => f.write_str("1 frame failed"),
            n => write!(f, "{n} frames failed"),
        }
    }
}

impl std::error::Error for FramesFailed {}

/// The command that repeats one frame of this process's command alone.
pub fn command_of_frame(frame: i32) -> Result<String, Error> {
    let replay = Replay::of_process()?.without(&["part", "part-base"]);
    Ok(replay.with("range", frame.to_string()).shell_line())
}
