//! Progress as one event per line, for programs that observe a job (`--progress json` and `openjd`).
//!
//! The lines of `openjd` are those of Open Job Description's "How Jobs Are Run": `openjd_progress`, `openjd_status`, `openjd_fail`.

use std::sync::atomic::{AtomicUsize, Ordering};

use batch_render::batch::{FrameFailure, JobEvent, Observer};

use super::progress::say;

/// The form of the lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventFormat {
    Json,
    OpenJd,
}

/// Prints the events of a job.
pub struct Events {
    format: EventFormat,
    /// The frames of the job.
    total: usize,
    done: AtomicUsize,
}

impl Events {
    pub fn new(format: EventFormat, total: usize) -> Self {
        Self {
            format,
            total,
            done: AtomicUsize::new(0),
        }
    }

    /// The lines of Open Job Description: the status, and how much is done once a frame is on disk or has failed.
    fn openjd(&self, event: &JobEvent<'_>) {
        let (status, is_done) = match event {
            JobEvent::FrameStarted { frame, .. } => (format!("frame {frame} renders"), false),
            JobEvent::FrameSkipped { frame } => (format!("frame {frame} is there"), true),
            JobEvent::FrameWritten { frame } => (format!("frame {frame} is written"), true),
            JobEvent::FrameFailed(FrameFailure { frame, cause }) => (format!("frame {frame} failed: {cause}"), true),
            _ => return,
        };
        say(&format!("openjd_status: {status}"));
        if is_done {
            let done = self.done.fetch_add(1, Ordering::SeqCst) + 1;
            let part = done as f64 / self.total.max(1) as f64;
            say(&format!("openjd_progress: {:.1}", 100.0 * part));
        }
    }
}

impl Observer for Events {
    fn event(&self, event: &JobEvent<'_>) {
        match (self.format, event) {
            (EventFormat::OpenJd, _) => self.openjd(event),
            (EventFormat::Json, JobEvent::FrameImage { .. }) => {}
            // A value has its keys in alphabetical order.
            (EventFormat::Json, _) => say(&serde_json::to_value(event).expect("events are plain data").to_string()),
        }
    }
}
