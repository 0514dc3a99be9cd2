//! Progress as one event per line, for programs that observe a job (`--progress json` and `openjd`).
//!
//! The lines of `openjd` are those of Open Job Description's "How Jobs Are Run": `openjd_progress`, `openjd_status`, `openjd_fail`.

use std::{
    path::Path,
    sync::atomic::{AtomicUsize, Ordering},
    time::Duration,
};

use batch_render::batch::{FrameFailure, Observer, Stale};
use serde_json::{Value, json};

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

    /// Prints the event of a frame that is on disk or has failed.
    fn is_done(&self, json: Value, status: &str) {
        let done = self.done.fetch_add(1, Ordering::SeqCst) + 1;
        match self.format {
            EventFormat::Json => say(&json.to_string()),
            EventFormat::OpenJd => {
                say(&format!("openjd_status: {status}"));
                say(&format!(
                    "openjd_progress: {:.1}",
                    100.0 * done as f64 / self.total.max(1) as f64
                ));
            }
        }
    }

    /// Prints an event that exists only in JSON.
    fn json(&self, event: impl FnOnce() -> Value) {
        if self.format == EventFormat::Json {
            say(&event().to_string());
        }
    }
}

impl Observer for Events {
    fn frame_started(&self, number: i32, index: usize, total: usize) {
        match self.format {
            EventFormat::Json => {
                self.json(|| json!({ "event": "frame_started", "frame": number, "index": index, "total": total }));
            }
            EventFormat::OpenJd => say(&format!("openjd_status: frame {number} renders")),
        }
    }

    fn frame_rendered(&self, number: i32, took: Duration) {
        self.json(|| json!({ "event": "frame_rendered", "frame": number, "seconds": took.as_secs_f64() }));
    }

    fn frame_skipped(&self, number: i32) {
        let event = json!({ "event": "frame_skipped", "frame": number });
        self.is_done(event, &format!("frame {number} is there"));
    }

    fn frame_stale(&self, number: i32, stale: &Stale) {
        let (file, reason) = (stale.path.display().to_string(), stale.reason.to_string());
        self.json(|| json!({ "event": "frame_stale", "frame": number, "file": file, "reason": reason }));
    }

    fn frame_failed(&self, failure: &FrameFailure) {
        let (number, cause) = (failure.frame, failure.cause.to_string());
        let status = format!("frame {number} failed: {cause}");
        self.is_done(
            json!({ "event": "frame_failed", "frame": number, "reason": cause }),
            &status,
        );
    }

    fn file_written(&self, number: i32, path: &Path) {
        self.json(|| json!({ "event": "file_written", "frame": number, "file": path.display().to_string() }));
    }

    fn frame_written(&self, number: i32) {
        let event = json!({ "event": "frame_written", "frame": number });
        self.is_done(event, &format!("frame {number} is written"));
    }
}
