//! Writing rendered frames while the next ones render.
//!
//! A file is whole on disk before it has its name, and waiting for the disk takes a few milliseconds, whatever the size of the
//! file. So small frames wait for each other, [`HOLD`] at most, and are made durable together.

use std::{
    path::Path,
    sync::mpsc::{Receiver, RecvTimeoutError},
    thread,
    time::{Duration, Instant},
};

use super::{
    Fingerprint, FrameError, FrameFailure, JobEvent, Observer, OnFailure, Plan, PlannedFrame,
    plan::time_limit,
    resume::{checkpoint, failure},
};
use crate::{
    camera::FrameCamera,
    film::Film,
    output::{
        self, Coverage, Format, FrameImage, FrameMetadata, OutputError, PendingFile, WriteReport, atomic,
        png::data::saturation,
    },
    warnings::WarningKind,
};

/// The time before the second attempt to write a file; it doubles with each one.
const FIRST_PAUSE: Duration = Duration::from_millis(200);

/// The longest time that a small frame waits for others.
const HOLD: Duration = Duration::from_millis(100);

/// The most pixels of frames that wait together, and the most files of them.
const MOST_PIXELS: usize = 1 << 16;
const MOST_FILES: usize = 256;

/// A rendered frame on its way to disk.
pub(super) struct Finished<'a> {
    pub frame: &'a PlannedFrame,
    pub camera: FrameCamera,
    pub film: Film,
    pub fingerprint: Fingerprint,
}

impl Finished<'_> {
    fn pixels(&self) -> usize {
        let window = self.film.window;
        window.width() as usize * window.height() as usize
    }
}

/// The results of writing.
#[derive(Default)]
pub(super) struct WriteSummary {
    /// Values that did not fit into their files.
    pub clamped: u64,
    /// The number of final pictures.
    pub written: usize,
    /// The frames whose files are on disk.
    pub done: Vec<i32>,
    pub failures: Vec<FrameFailure>,
}

/// Writes frames as they come.
///
/// # Errors
/// A file could not be written, and the job is to end.
pub(super) fn write_all(
    plan: &Plan,
    coverage: Coverage,
    frames: Receiver<Finished<'_>>,
    observer: &dyn Observer,
) -> Result<WriteSummary, OutputError> {
    let mut writer = Writer {
        plan,
        coverage,
        observer,
        summary: WriteSummary::default(),
        saturated: 0,
    };
    writer.write_all(frames)?;
    if writer.saturated > 0 {
        let text = saturation(writer.saturated, plan.files.encoding.depth);
        plan.warnings.add(WarningKind::SATURATED, "--png-depth", text);
    }
    Ok(writer.summary)
}

struct Writer<'p> {
    plan: &'p Plan,
    coverage: Coverage,
    observer: &'p dyn Observer,
    summary: WriteSummary,
    saturated: u64,
}

/// A frame whose files have not yet their names.
struct Held<'a> {
    finished: Finished<'a>,
    files: Vec<PendingFile>,
    reports: Vec<WriteReport>,
}

/// Frames that wait for each other.
#[derive(Default)]
struct Batch<'a> {
    held: Vec<Held<'a>>,
    /// When the first of them came.
    since: Option<Instant>,
}

impl Batch<'_> {
    fn has_room_for(&self, finished: &Finished<'_>) -> bool {
        let pixels = self.held.iter().map(|held| held.finished.pixels()).sum::<usize>();
        let files = self.held.iter().map(|held| held.files.len()).sum::<usize>();
        pixels + finished.pixels() <= MOST_PIXELS && files + finished.frame.files.len() <= MOST_FILES
    }
}

/// Whether a job goes on after a frame.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Next {
    GoesOn,
    Ends,
}

impl Writer<'_> {
    fn write_all(&mut self, frames: Receiver<Finished<'_>>) -> Result<(), OutputError> {
        let mut batch = Batch::default();
        loop {
            let next = match batch.since {
                None => frames.recv().map_err(|_| RecvTimeoutError::Disconnected),
                Some(since) => frames.recv_timeout(HOLD.saturating_sub(since.elapsed())),
            };
            let next = match next {
                Ok(finished) => self.add(&mut batch, finished)?,
                Err(RecvTimeoutError::Timeout) => self.put(&mut batch)?,
                Err(RecvTimeoutError::Disconnected) => {
                    self.put(&mut batch)?;
                    Next::Ends
                }
            };
            if next == Next::Ends {
                // Frames that wait are whole.
                return self.put(&mut batch).map(drop);
            }
        }
    }

    /// Adds a frame to those that wait, or writes them and it.
    fn add<'a>(&mut self, batch: &mut Batch<'a>, finished: Finished<'a>) -> Result<Next, OutputError> {
        if !batch.has_room_for(&finished) && self.put(batch)? == Next::Ends {
            return Ok(Next::Ends);
        }
        if let Err(cause) = failure::catch(|| self.tell_picture(&finished)) {
            return Ok(self.fail(finished.frame, cause));
        }
        if batch.has_room_for(&finished)
            && let Some((files, reports)) = self.pending(&finished)
        {
            batch.since.get_or_insert_with(Instant::now);
            batch.held.push(Held {
                finished,
                files,
                reports,
            });
            return Ok(Next::GoesOn);
        }
        match self.put(batch)? {
            Next::GoesOn => self.write_alone(&finished),
            Next::Ends => Ok(Next::Ends),
        }
    }

    /// The files of a frame without their names; `None` where one cannot be written.
    fn pending(&self, finished: &Finished<'_>) -> Option<(Vec<PendingFile>, Vec<WriteReport>)> {
        let metadata = self.metadata(finished);
        let image = self.image(finished, &metadata);
        let files = finished.frame.files.iter();
        let written = failure::catch(|| {
            let written =
                files.map(|file| output::write_pending(&file.path, file.format, &image, self.plan.files.encoding));
            written.collect::<Result<Vec<_>, _>>()
        });
        Some(written.ok()?.ok()?.into_iter().unzip())
    }

    /// Gives the files of the frames that wait their names. Where that fails, each frame is written anew.
    fn put(&mut self, batch: &mut Batch<'_>) -> Result<Next, OutputError> {
        let mut held = std::mem::take(batch).held;
        let files = held.iter_mut().flat_map(|held| held.files.drain(..)).collect();
        let are_put = atomic::put(files).is_ok();
        let mut all = Next::GoesOn;
        for held in held {
            let next = match are_put {
                true => {
                    self.count(&held.reports);
                    let frame = held.finished.frame;
                    let told = failure::catch(|| frame.files.iter().for_each(|file| self.tell_file(frame, &file.path)));
                    match told {
                        Ok(()) => self.succeed(frame),
                        Err(cause) => self.fail(frame, cause),
                    }
                }
                false => self.write_alone(&held.finished)?,
            };
            if next == Next::Ends {
                all = next;
            }
        }
        Ok(all)
    }

    /// Writes the files of a frame, one after the other, in several attempts if that may help.
    fn write_alone(&mut self, finished: &Finished<'_>) -> Result<Next, OutputError> {
        let metadata = self.metadata(finished);
        let image = self.image(finished, &metadata);
        let frame = finished.frame;
        let written = failure::catch(|| {
            frame.files.iter().try_for_each(|file| {
                let report = write(self.plan, &file.path, file.format, &image)?;
                self.count(&[report]);
                self.tell_file(frame, &file.path);
                Ok(())
            })
        });
        match written.and_then(|written: Result<(), OutputError>| Ok(written?)) {
            Ok(()) => Ok(self.succeed(frame)),
            Err(FrameError::Output(error))
                if error.ends_the_job() || self.plan.policy.on_failure == OnFailure::FailFast =>
            {
                Err(error)
            }
            Err(cause) => Ok(self.fail(frame, cause)),
        }
    }

    fn metadata(&self, finished: &Finished<'_>) -> FrameMetadata {
        let Finished {
            frame,
            camera,
            film,
            fingerprint,
        } = finished;
        let mut metadata = fingerprint.metadata(self.plan, frame.number, camera);
        time_limit::mark(&mut metadata, self.plan, film);
        metadata
    }

    fn image<'i>(&self, finished: &'i Finished<'_>, metadata: &'i FrameMetadata) -> FrameImage<'i> {
        FrameImage {
            film: &finished.film,
            shown: self.plan.picture.shown,
            coverage: self.coverage,
            metadata,
        }
    }

    fn is_final(&self) -> bool {
        self.plan.denoises().is_none()
    }

    fn tell_picture(&self, finished: &Finished<'_>) {
        if self.is_final() {
            let metadata = self.metadata(finished);
            self.observer.event(&JobEvent::FrameImage {
                frame: finished.frame.number,
                image: &self.image(finished, &metadata),
            });
        }
    }

    fn tell_file(&self, frame: &PlannedFrame, file: &Path) {
        self.observer.event(&JobEvent::FileWritten {
            frame: frame.number,
            file,
        });
    }

    fn count(&mut self, reports: &[WriteReport]) {
        for report in reports {
            self.summary.clamped += report.clamped + report.nans;
            self.saturated += report.saturated;
        }
    }

    fn succeed(&mut self, frame: &PlannedFrame) -> Next {
        if self.plan.policy.checkpoint.is_some() {
            checkpoint::remove(frame);
        }
        self.summary.done.push(frame.number);
        if self.is_final() {
            self.summary.written += 1;
            self.observer.event(&JobEvent::FrameWritten { frame: frame.number });
        }
        Next::GoesOn
    }

    fn fail(&mut self, frame: &PlannedFrame, cause: FrameError) -> Next {
        let failure = FrameFailure {
            frame: frame.number,
            cause,
        };
        self.observer.event(&JobEvent::FrameFailed(&failure));
        self.summary.failures.push(failure);
        match self.plan.policy.on_failure {
            OnFailure::FailFast => Next::Ends,
            OnFailure::KeepGoing => Next::GoesOn,
        }
    }
}

/// Writes a picture, in several attempts if that may help.
pub(super) fn write(
    plan: &Plan,
    path: &Path,
    format: &dyn Format,
    image: &FrameImage<'_>,
) -> Result<WriteReport, OutputError> {
    attempts(plan, || output::write(path, format, image, plan.files.encoding))
}

/// Writes a file, in several attempts if that may help.
pub(super) fn attempts<T>(plan: &Plan, write: impl Fn() -> Result<T, OutputError>) -> Result<T, OutputError> {
    let mut pause = FIRST_PAUSE;
    for _ in 0..plan.policy.retries {
        match write() {
            Err(error) if error.may_pass() => {
                let text = format!("{error}; another attempt follows");
                plan.warnings.add_live(WarningKind::RETRY, error.path().display(), text);
                thread::sleep(pause);
                pause *= 2;
            }
            done => return done,
        }
    }
    write()
}
