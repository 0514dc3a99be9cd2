//! Failures of single frames, after which a job may continue.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
};

use serde::Serialize;

use crate::{batch::as_text, error::Error, output::OutputError};

/// Whether a job continues after a failed frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnFailure {
    /// The job continues, except after an error of a full or read-only disk.
    #[default]
    KeepGoing,
    /// The job ends.
    FailFast,
}

/// Why a frame failed.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// A fault of the program.
    #[error("it panicked: {0}")]
    Panic(String),
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The scene of the frame is wrong.
    #[error(transparent)]
    Scene(Box<Error>),
}

impl FrameError {
    /// The texts of the problems, one for each.
    pub fn messages(&self) -> Vec<String> {
        match self {
            Self::Scene(error) => error.messages(),
            other => vec![other.to_string()],
        }
    }

    /// Whether the messages show lines of a file below them.
    pub fn has_excerpts(&self) -> bool {
        matches!(self, Self::Scene(error) if error.has_excerpts())
    }
}

impl From<Error> for FrameError {
    fn from(cause: Error) -> Self {
        match cause {
            Error::Output(cause) => Self::Output(cause),
            other => Self::Scene(Box::new(other)),
        }
    }
}

/// A frame that failed.
#[derive(Debug, Serialize)]
pub struct FrameFailure {
    pub frame: i32,
    #[serde(rename = "reason", serialize_with = "as_text::text")]
    pub cause: FrameError,
}

/// Returns what `work` returns, or the message with which it panicked.
pub(in crate::batch) fn catch<T>(work: impl FnOnce() -> T) -> Result<T, FrameError> {
    // The caller drops all state that a panic may have left inconsistent.
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload| FrameError::Panic(message(&*payload)))
}

fn message(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "without a message".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_with_its_message_on_any_thread() {
        assert_eq!(catch(|| 7).expect("no panic"), 7);
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("a pool");
            let work = || rayon::join(|| (), || panic!("frame {}", 5));
            let error = catch(|| pool.install(work)).expect_err("a panic");
            assert_eq!(error.to_string(), "it panicked: frame 5");
        }
    }
}
