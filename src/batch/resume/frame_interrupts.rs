//! The interrupts of a job's frame: saving checkpoints and the sums of all samples, and showing the unfinished frame.

use std::{
    fmt,
    path::PathBuf,
    sync::atomic::{AtomicU64, Ordering},
    time::{Duration, Instant},
};

use super::checkpoint;
use crate::{
    batch::{Plan, PlannedFrame},
    output::{self, Coverage, FrameImage},
    render::{Interrupts, PartialFrame, ShowRequest},
    warnings::WarningKind,
};

/// The interrupts of one frame.
pub(in crate::batch) struct FrameInterrupts<'a> {
    plan: &'a Plan,
    frame: &'a PlannedFrame,
    fingerprint: &'a str,
    /// The fingerprint of kept sums.
    sums: Option<String>,
    coverage: Coverage,
    show: Option<&'a ShowRequest>,
    start: Instant,
    /// When the next checkpoint is due, in milliseconds after the start.
    checkpoint_at: AtomicU64,
}

impl<'a> FrameInterrupts<'a> {
    pub fn new(
        plan: &'a Plan,
        (frame, fingerprint, sums): (&'a PlannedFrame, &'a str, Option<String>),
        coverage: Coverage,
        show: Option<&'a ShowRequest>,
    ) -> Self {
        let first = plan.policy.checkpoint.map_or(u64::MAX, milliseconds);
        Self {
            plan,
            frame,
            fingerprint,
            sums,
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
        self.plan.policy.checkpoint.is_some() || self.sums.is_some()
    }

    fn earlier_state(&self) -> Option<Vec<u8>> {
        let checkpoint = || Some((self.checkpoint_path()?, self.fingerprint));
        let sums = || Some((checkpoint::sums_path(self.frame)?, self.sums.as_deref()?));
        let found = [checkpoint(), sums()]
            .into_iter()
            .flatten()
            .find_map(|(path, fingerprint)| {
                let state = checkpoint::read(&path, fingerprint, &self.plan.warnings)?;
                Some((path, state))
            });
        let (path, state) = found?;
        tracing::info!("frame {} goes on from {}", self.frame.number, path.display());
        Some(state)
    }

    fn earlier_state_is_left(&self) {
        let cause = "more samples can be added to a frame that does not move, and that had fewer";
        self.warn(WarningKind::CHECKPOINT, "starts without its kept sums", cause);
    }

    fn finished(&self, frame: &PartialFrame<'_>) {
        let Some((path, sums)) = checkpoint::sums_path(self.frame).zip(self.sums.as_deref()) else {
            return;
        };
        if let Err(error) = checkpoint::write(&path, sums, &frame.state()) {
            self.warn(WarningKind::CHECKPOINT, "does not keep its sums", error);
        }
    }
}

fn milliseconds(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}
