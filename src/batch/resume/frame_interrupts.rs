//! The interrupts of a job's frame: saving checkpoints and the sums of all samples, and showing the unfinished frame.

use std::{
    fmt,
    path::PathBuf,
    sync::{
        Mutex,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use super::checkpoint;
use crate::{
    batch::{Fingerprint, InputHash, Plan, PlannedFrame},
    output::{self, Coverage, FrameImage, OutputError},
    render::{Interrupts, PartialFrame, SampleRanges, ShowRequest},
    warnings::WarningKind,
};

/// The interrupts of one frame.
pub(in crate::batch) struct FrameInterrupts<'a> {
    plan: &'a Plan,
    frame: &'a PlannedFrame,
    inputs: InputHash,
    fingerprint: &'a str,
    /// Why the sums of the samples are not kept.
    lost: Mutex<Option<OutputError>>,
    coverage: Coverage,
    show: Option<&'a ShowRequest>,
    start: Instant,
    /// When the next checkpoint is due, in milliseconds after the start.
    checkpoint_at: AtomicU64,
}

impl<'a> FrameInterrupts<'a> {
    pub fn new(
        plan: &'a Plan,
        (frame, inputs, fingerprint): (&'a PlannedFrame, InputHash, &'a str),
        coverage: Coverage,
        show: Option<&'a ShowRequest>,
    ) -> Self {
        let first = plan.policy.checkpoint.map_or(u64::MAX, milliseconds);
        Self {
            plan,
            frame,
            inputs,
            fingerprint,
            lost: Mutex::new(None),
            coverage,
            show,
            start: Instant::now(),
            checkpoint_at: AtomicU64::new(first),
        }
    }

    fn checkpoint_is_due(&self) -> bool {
        let at = self.checkpoint_at.load(Ordering::Relaxed);
        at < u64::MAX && milliseconds(self.start.elapsed()) >= at
    }

    /// Why the sums of all samples are not kept, if they are to be and that failed.
    pub fn lost(&self) -> Option<OutputError> {
        self.lost
            .lock()
            .expect("no thread panics while it holds an error")
            .take()
    }

    /// The kept sums of the samples, or of the range with this number, and their fingerprint.
    fn sums(&self, range: Option<u32>) -> Option<(PathBuf, String)> {
        let path = match (self.plan.picture.settings.ranges, range) {
            (Some(ranges @ SampleRanges { only: None, .. }), Some(index)) => {
                checkpoint::range_path(self.frame, ranges.only(index)).filter(|path| path.exists())
            }
            _ if self.plan.keeps_sums() => checkpoint::sums_path(self.frame),
            _ => None,
        };
        Some((path?, Fingerprint::of_sums(self.plan, self.inputs, self.frame, range)))
    }

    fn checkpoint_path(&self) -> Option<PathBuf> {
        checkpoint::path(self.frame).filter(|_| self.plan.policy.checkpoint.is_some())
    }

    fn warn(&self, kind: WarningKind, what: &str, cause: impl fmt::Display) {
        let number = self.frame.number;
        let text = format!("frame {number} {what}: {cause}");
        self.plan.warnings.add_live(kind, number, text);
    }

    /// Writes the picture of the unfinished frame.
    fn show(&self, partial: &PartialFrame<'_>) {
        let Some(path) = checkpoint::picture_path(self.frame) else {
            return;
        };
        let film = partial.film();
        let mut metadata = self.plan.metadata(self.frame.number);
        metadata.samples = film.samples;
        let image = FrameImage {
            film: &film,
            shown: self.plan.picture.shown,
            coverage: self.coverage,
            metadata: &metadata,
        };
        let format = output::format("exr").expect("it is among the formats");
        match output::write(&path, format, &image, self.plan.files.encoding) {
            Ok(_) => self.warn(WarningKind::PARTIAL_FRAME, "as it stands", path.display()),
            Err(error) => self.warn(WarningKind::PARTIAL_FRAME, "as it stands", error),
        }
    }

    /// Saves a checkpoint. If that fails, rendering continues.
    fn keep(&self, partial: &PartialFrame<'_>) {
        let Some(path) = self.checkpoint_path() else { return };
        match checkpoint::write(&path, self.fingerprint, &partial.state()) {
            Ok(()) => tracing::info!("frame {} is kept: {}", self.frame.number, path.display()),
            Err(error) => self.warn(WarningKind::CHECKPOINT, "is not kept", error),
        }
        let interval = self.plan.policy.checkpoint.unwrap_or(Duration::MAX);
        let next = self.start.elapsed().saturating_add(interval);
        self.checkpoint_at.store(milliseconds(next), Ordering::Relaxed);
    }
}

impl Interrupts for FrameInterrupts<'_> {
    fn are_due(&self) -> bool {
        self.show.is_some_and(ShowRequest::is_open) || self.checkpoint_is_due()
    }

    fn pause(&self, frame: &PartialFrame<'_>) {
        if frame.is_cancelled || self.checkpoint_is_due() {
            self.keep(frame);
        }
        if self.show.is_some_and(ShowRequest::take) {
            self.show(frame);
        }
    }

    fn keep_state(&self) -> bool {
        self.plan.policy.checkpoint.is_some() || self.plan.keeps_sums()
    }

    fn earlier_state(&self, range: Option<u32>) -> Option<Vec<u8>> {
        let checkpoint = || Some((self.checkpoint_path()?, self.fingerprint.to_owned()));
        let read = |(path, fingerprint): (PathBuf, String), what: &str| {
            let state = checkpoint::read(&path, &fingerprint, &self.plan.warnings)?;
            tracing::info!("frame {} {what} {}", self.frame.number, path.display());
            Some(state)
        };
        let unfinished = checkpoint().and_then(|of| read(of, "goes on from"));
        // Whether samples can be added to sums is not known yet.
        unfinished.or_else(|| read(self.sums(range)?, "has kept sums in"))
    }

    fn earlier_state_is_left(&self) {
        let cause = "more samples can be added to a frame that does not move, and that had fewer";
        self.warn(WarningKind::CHECKPOINT, "starts without its kept sums", cause);
    }

    fn finished(&self, frame: &PartialFrame<'_>) {
        let range = self.plan.picture.settings.ranges.and_then(|ranges| ranges.only);
        let Some((path, fingerprint)) = self.sums(range).filter(|_| self.plan.keeps_sums()) else {
            return;
        };
        let written = checkpoint::write(&path, &fingerprint, &frame.state());
        *self.lost.lock().expect("no thread panics while it holds an error") = written.err();
    }
}

fn milliseconds(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}
