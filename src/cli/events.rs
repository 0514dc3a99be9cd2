//! Progress as one event per line, for programs that observe a job (`--progress json` and `openjd`).
//!
//! The lines of `openjd` are those of Open Job Description's "How Jobs Are Run": `openjd_progress`, `openjd_status`, `openjd_fail`.

use std::{
    collections::BTreeMap,
    sync::{Mutex, PoisonError},
};

use batch_render::{
    batch::{FrameFailure, Job, JobEvent, Observer, Plan},
    camera::stereo::Side,
};
use serde_json::Value;

use super::progress::say;

/// The form of the lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventFormat {
    Json,
    OpenJd,
}

/// Prints the events of a job.
pub struct Events<'a> {
    format: EventFormat,
    plan: &'a Plan,
    /// Keys of all lines of JSON: the scene, and its eye in stereo.
    source: Vec<(&'static str, String)>,
    /// The finished part of each frame, in halves: it is rendered, and it has come to its end.
    halves: Mutex<BTreeMap<i32, u32>>,
    /// The number of jobs of the command before this one, and of all.
    share: (usize, usize),
}

impl<'a> Events<'a> {
    /// The events of a job, whose pictures are those of this eye in stereo, after so many jobs of the command, and of so many.
    pub fn new(format: EventFormat, job: &'a Job, eye: Option<Side>, share: (usize, usize)) -> Self {
        let scene = ("scene", job.desc.source.path.display().to_string());
        let eye = eye.map(|side| ("eye", side.name().to_owned()));
        Self {
            format,
            plan: &job.plan,
            source: [scene].into_iter().chain(eye).collect(),
            halves: Mutex::default(),
            share,
        }
    }

    /// The line of an event. Its keys are in alphabetical order.
    fn json(&self, event: &JobEvent<'_>) -> String {
        let mut line = serde_json::to_value(event).expect("events are plain data");
        for (key, value) in &self.source {
            line[key] = Value::from(value.as_str());
        }
        line.to_string()
    }

    /// The lines of Open Job Description: the status, and how much is done once a frame is on disk or has failed. Where frames
    /// are denoised, a rendered one is half of the work.
    fn openjd(&self, event: &JobEvent<'_>) {
        let is_denoised = self.plan.renders() && self.plan.denoises().is_some();
        let (frame, status, halves) = match event {
            JobEvent::FrameStarted { frame, .. } => (frame, "renders".to_owned(), 0),
            JobEvent::FrameRendered { frame, .. } if is_denoised => (frame, "is rendered".to_owned(), 1),
            JobEvent::FrameSkipped { frame } => (frame, "is there".to_owned(), 2),
            JobEvent::FrameWritten { frame } => (frame, "is written".to_owned(), 2),
            JobEvent::FrameFailed(FrameFailure { frame, cause }) => {
                // A status is one line: without the excerpts of files.
                let messages = cause.messages();
                let lines = messages.iter().filter_map(|message| message.lines().next());
                (frame, format!("failed: {}", lines.collect::<Vec<_>>().join("; ")), 2)
            }
            _ => return,
        };
        say(&format!("openjd_status: frame {frame} {status}"));
        if halves > 0 {
            let mut all = self.halves.lock().unwrap_or_else(PoisonError::into_inner);
            all.insert(*frame, halves);
            let done = f64::from(all.values().sum::<u32>());
            let part = 0.5 * done / self.plan.frames.len().max(1) as f64;
            let (before, jobs) = self.share;
            // The jobs that follow are not loaded yet: each counts as much as any other.
            let part = (before as f64 + part) / jobs as f64;
            say(&format!("openjd_progress: {:.1}", 100.0 * part));
        }
    }
}

impl Observer for Events<'_> {
    fn event(&self, event: &JobEvent<'_>) {
        match (self.format, event) {
            (EventFormat::OpenJd, _) => self.openjd(event),
            // Not for programs; they are not serialized.
            (EventFormat::Json, JobEvent::FrameImage { .. } | JobEvent::DenoisedFingerprint { .. }) => {}
            (EventFormat::Json, _) => say(&self.json(event)),
        }
    }
}
