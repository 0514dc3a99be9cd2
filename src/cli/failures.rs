//! Frames that failed: what to say of each, and the exit code.

use std::fmt;

use batch_render::{
    batch::{FrameError, FrameFailure, Summary},
    error::{Blame, Error},
};

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
pub fn command_of_frame(frame: i32) -> String {
    command(std::env::args(), frame)
}

fn command(typed: impl Iterator<Item = String>, frame: i32) -> String {
    let mut words = Vec::new();
    let mut typed = typed;
    while let Some(word) = typed.next() {
        match word.as_str() {
            "--range" | "-r" | "--part" | "--part-base" => drop(typed.next()),
            other
                if ["--range=", "--part=", "--part-base="]
                    .iter()
                    .any(|flag| other.starts_with(flag)) => {}
            other if other.starts_with("-r") && !other.starts_with("--") => {}
            _ => words.push(quoted(&word)),
        }
    }
    words.push(format!("--range={frame}"));
    words.join(" ")
}

/// The word as a shell reads it.
pub fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_=+./,:@%#".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) && !word.starts_with('#') {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_of_a_frame_has_its_range_alone() {
        let typed = "batch-render s.toml --frames p.csv -r 1-100 --part=2/4 --samples 4";
        let words = typed.split(' ').map(str::to_owned).chain(["it's here.toml".to_owned()]);
        assert_eq!(
            command(words, -5),
            "batch-render s.toml --frames p.csv --samples 4 'it'\\''s here.toml' --range=-5"
        );
    }
}
