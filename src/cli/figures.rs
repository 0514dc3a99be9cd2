//! The statistics of a job in files.

use std::{borrow::Cow, collections::BTreeMap};

use batch_render::{batch::Summary, error::Error, math::sorting, warnings::Warning};
use serde::{Deserialize, Serialize};

/// All figures.
#[derive(Clone, Serialize, Deserialize)]
pub struct Report {
    pub version: Cow<'static, str>,
    pub command: Vec<String>,
    pub scene: String,
    /// The eye in stereo that the pictures are those of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye: Option<String>,
    /// The hash of all that files of all frames depend on, but for their numbers and cameras.
    #[serde(default)]
    pub settings: String,
    pub resolution: [u32; 2],
    /// The samples of each pixel, with adaptive sampling the most.
    pub samples: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_samples: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_threshold: Option<f32>,
    pub threads: usize,
    /// The number of frames of the job.
    pub total: usize,
    /// The part of the job that the process makes, as `--part` names it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    pub wall_s: f64,
    /// The state of the process.
    pub state: State,
    /// Whether all frames of the job are on disk.
    pub is_finished: bool,
    pub inputs: Vec<Input>,
    /// Those of this process.
    #[serde(skip_deserializing)]
    pub warnings: Vec<Warning>,
    pub frames: Vec<Frame>,
}

impl Report {
    /// Adds the frames of other jobs with the same settings, in rising order. A frame that this job renders replaces theirs. One
    /// that it skips or only denoises keeps the figures of its rendering.
    pub fn join(&mut self, others: Vec<Frame>) {
        let mut frames: BTreeMap<i32, Frame> = sorting::ordered(others.into_iter().map(|frame| (frame.frame, frame)));
        for mut own in self.frames.drain(..) {
            if let Some(theirs) = frames.remove(&own.frame) {
                own.continue_from(theirs);
            }
            frames.insert(own.frame, own);
        }
        self.frames = frames.into_values().collect();
        self.total = self.total.max(self.frames.len());
        self.settle();
    }

    /// Finds out whether all frames of the job are on disk.
    pub fn settle(&mut self) {
        let is_there = |frame: &&Frame| matches!(frame.status, Status::Written | Status::Skipped);
        let there = self.frames.iter().filter(is_there).count();
        self.is_finished = self.state == State::Finished && there == self.total;
    }
}

/// The figures of a report, with small pictures of some frames as addresses of images.
#[derive(Clone, Serialize, Deserialize)]
pub struct Album {
    pub figures: Report,
    pub thumbnails: BTreeMap<i32, String>,
}

impl Album {
    /// The most thumbnails, with which a page stays small.
    pub const MAX_THUMBNAILS: usize = 300;

    /// Adds the frames of other jobs with the same settings, and their thumbnails as long as there is room.
    pub fn join(&mut self, others: Self) {
        let known = |frame: &i32| others.figures.frames.iter().any(|known| known.frame == *frame);
        for (frame, thumbnail) in others.thumbnails.into_iter().filter(|(frame, _)| known(frame)) {
            self.thumbnails.entry(frame).or_insert(thumbnail);
        }
        self.figures.join(others.figures.frames);
        while self.thumbnails.len() > Self::MAX_THUMBNAILS {
            let thinned = std::mem::take(&mut self.thumbnails).into_iter().step_by(2);
            self.thumbnails.extend(thinned);
        }
    }
}

/// The figures of several scenes of one command.
#[derive(Serialize, Deserialize)]
pub struct SceneReports {
    pub version: Cow<'static, str>,
    pub command: Vec<String>,
    pub wall_s: f64,
    /// The state of the process.
    pub state: State,
    /// Whether all frames of all scenes are on disk.
    pub is_finished: bool,
    pub scenes: Vec<SceneReport>,
}

/// The figures of one of them.
#[derive(Clone, Serialize, Deserialize)]
pub struct SceneReport {
    /// The name that replaces `{scene}`.
    pub name: String,
    /// Its path, as typed.
    pub scene: String,
    pub state: State,
    /// Why it has failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Those of its job, once it is loaded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub figures: Option<Report>,
}

impl SceneReport {
    /// Whether all its frames are on disk.
    pub fn is_finished(&self) -> bool {
        self.figures.as_ref().is_some_and(|figures| figures.is_finished)
    }
}

/// The state of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// The scene comes after others of the command.
    Waiting,
    Running,
    /// All frames are on disk.
    Finished,
    /// A signal has ended the job.
    Interrupted,
    /// An error has ended the job, or frames have failed.
    Failed,
}

impl State {
    /// The state of a job that has ended with this result.
    pub fn of(result: &Result<Summary, Error>) -> Self {
        match result {
            Ok(summary) if summary.failures.is_empty() => Self::Finished,
            Err(Error::Cancelled(_)) => Self::Interrupted,
            _ => Self::Failed,
        }
    }

    /// The state of a command, or of one of its scenes, that has ended with this result.
    pub fn of_command(result: &anyhow::Result<()>) -> Self {
        let error = result.as_ref().err().map(|error| error.downcast_ref::<Error>());
        match error {
            None => Self::Finished,
            Some(Some(Error::Cancelled(_))) => Self::Interrupted,
            Some(_) => Self::Failed,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Running => "running",
            Self::Finished => "finished",
            Self::Interrupted => "interrupted",
            Self::Failed => "failed",
        }
    }
}

#[derive(Clone, Serialize, Deserialize)]
pub struct Input {
    pub path: String,
    pub hash: String,
}

#[derive(Clone, Serialize, Deserialize)]
pub struct Frame {
    pub frame: i32,
    pub status: Status,
    /// Why it was rendered again, or failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    pub wall_s: f64,
    /// The processor time of all threads while it rendered, including that of writing the last frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpu_s: Option<f64>,
    pub samples: u64,
    /// The samples of each pixel, if a time limit has reduced them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples_per_pixel: Option<u32>,
    pub segments: u64,
    pub shadow_rays: u64,
    /// The peak of the process so far.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_memory_bytes: Option<u64>,
    pub files: Vec<String>,
    /// The fingerprint of its final files.
    pub fingerprint: String,
    /// The fingerprint of its rendered files, where the job has denoised them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noisy_fingerprint: Option<String>,
}

impl Frame {
    /// The fingerprint of its rendered files.
    fn rendered(&self) -> &str {
        self.noisy_fingerprint.as_deref().unwrap_or(&self.fingerprint)
    }

    /// Sets the fingerprint of the files that its rendered ones become.
    pub fn set_denoised(&mut self, fingerprint: &str) {
        let rendered = std::mem::replace(&mut self.fingerprint, fingerprint.to_owned());
        self.noisy_fingerprint.get_or_insert(rendered);
    }

    /// Takes over what `earlier` says of the same rendering, if this job has not rendered the frame itself.
    fn continue_from(&mut self, earlier: Self) {
        let is_kept = self.wall_s == 0.0 && matches!(self.status, Status::Skipped | Status::Written);
        if !is_kept || earlier.status == Status::Failed || self.rendered() != earlier.rendered() {
            return;
        }
        if self.status == Status::Skipped && earlier.status == Status::Written {
            self.status = earlier.status;
        }
        let own = std::mem::replace(self, earlier);
        let files = if own.files.is_empty() {
            std::mem::take(&mut self.files)
        } else {
            own.files
        };
        (self.status, self.files) = (own.status, files);
        (self.fingerprint, self.noisy_fingerprint) = (own.fingerprint, own.noisy_fingerprint);
    }
}

#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    Rendering,
    Rendered,
    Written,
    Skipped,
    Failed,
}
