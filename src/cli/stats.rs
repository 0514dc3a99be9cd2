//! Figures of a job, as JSON for programs (`--stats`) and as a page for people (`--report`): see docs/interface.md.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use super::{
    all_scenes::SceneFigures,
    arguments::arguments,
    figure_files::{ALBUM, Joining, PAGE, write_text},
    figures::{Album, Frame, Input, Report, State, Status},
    memory,
    report_page::{page, thumbnail},
};
use batch_render::{
    batch::{Fingerprint, FrameFailure, InputHash, Job, JobEvent, Observer, PartSpec, Plan},
    output::{FrameImage, OutputError, atomic, job_file::FolderGate},
    render::{Cancel, Counters},
};

/// The files are written again after a frame, but no more often than this, ...
const WRITE_EVERY: Duration = Duration::from_secs(1);
/// ... and only if as many times the duration of the last writing have passed.
const PAUSE: u32 = 50;

/// The work of the process so far.
#[derive(Clone, Copy)]
struct Work {
    samples: u64,
    segments: u64,
    rays: u64,
    cpu: Option<f64>,
}

struct Collected {
    album: Album,
    /// The work before the frame that renders.
    before: Work,
    written: Instant,
    /// The duration of the last writing.
    took: Duration,
}

/// The files that are kept.
#[derive(Clone, Default)]
pub struct StatsFiles<'a> {
    /// The figures for programs.
    pub json: Option<PathBuf>,
    /// The folder of the page for people.
    pub page: Option<PathBuf>,
    /// The files of all scenes of the command.
    pub of_all: Option<SceneFigures<'a>>,
}

impl StatsFiles<'_> {
    /// Whether any is kept.
    pub fn are_wanted(&self) -> bool {
        self.json.is_some() || self.page.is_some() || self.of_all.is_some()
    }
}

/// Collects the figures of a job and keeps their files.
pub struct Stats<'a> {
    files: StatsFiles<'a>,
    plan: &'a Plan,
    inputs: InputHash,
    joining: Option<Joining>,
    counters: &'a Counters,
    cancel: Option<&'a Cancel>,
    start: Instant,
    state: Mutex<Collected>,
}

impl<'a> Stats<'a> {
    /// Starts the figures of a job whose scene is loaded.
    pub fn new(
        files: StatsFiles<'a>,
        part: Option<PartSpec>,
        job: &'a Job,
        control: (&'a Counters, &'a Cancel),
    ) -> Self {
        let (counters, cancel) = control;
        let plan = &job.plan;
        let inputs = job.files().manifest().into_iter().map(|(path, hash)| Input {
            path: path.display().to_string(),
            hash: hash.to_string(),
        });
        let settings = Fingerprint::of_job(plan, job.inputs());
        let adaptive = plan.picture.settings.samples.adaptive;
        let report = Report {
            version: env!("CARGO_PKG_VERSION").into(),
            command: arguments().map(|word| word.to_string_lossy().into_owned()).collect(),
            scene: job.desc.source.path.display().to_string(),
            eye: plan.picture.eye().map(|side| side.name().to_owned()),
            settings: settings.clone(),
            resolution: plan.picture.resolution(),
            samples: plan.picture.settings.pixel_samples(),
            min_samples: adaptive.map(|rule| rule.min),
            noise_threshold: adaptive.map(|rule| rule.threshold),
            threads: rayon::current_num_threads(),
            total: plan.all_frames().len(),
            part: part.map(|part| part.to_string()),
            wall_s: 0.0,
            state: State::Running,
            is_finished: false,
            inputs: inputs.collect(),
            warnings: Vec::new(),
            frames: Vec::new(),
        };
        Self {
            files,
            plan,
            inputs: job.inputs(),
            joining: Joining::new(plan, &settings),
            counters,
            cancel: Some(cancel),
            start: Instant::now(),
            state: Mutex::new(Collected {
                album: Album {
                    figures: report,
                    thumbnails: BTreeMap::new(),
                },
                before: Work::so_far(counters),
                written: Instant::now(),
                took: Duration::ZERO,
            }),
        }
    }

    /// Writes the files for the last time, of a job that has ended in this state. Returns the errors of those that cannot be
    /// written.
    pub fn finish(self, end: State) -> Vec<OutputError> {
        let mut state = self.lock();
        state.album.figures.state = end;
        state.album.figures.settle();
        self.write(&mut state).into_iter().map(|(_, error)| error).collect()
    }

    fn lock(&self) -> MutexGuard<'_, Collected> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The entry of a frame, a new one where there is none.
    fn frame<'s>(&self, state: &'s mut Collected, number: i32) -> &'s mut Frame {
        let frames = &mut state.album.figures.frames;
        let at = frames.iter().rposition(|f| f.frame == number).unwrap_or_else(|| {
            let planned = self.plan.frames.iter().find(|f| f.number == number);
            let fingerprint = planned.map(|f| Fingerprint::of_frame(self.plan, self.inputs, f).file);
            frames.push(Frame {
                frame: number,
                status: Status::Rendering,
                reason: None,
                wall_s: 0.0,
                cpu_s: None,
                samples: 0,
                samples_per_pixel: None,
                segments: 0,
                shadow_rays: 0,
                peak_memory_bytes: None,
                files: Vec::new(),
                fingerprint: fingerprint.unwrap_or_default(),
                noisy_fingerprint: None,
            });
            frames.len() - 1
        });
        &mut frames[at]
    }

    fn keep_thumbnail(&self, number: i32, image: &FrameImage<'_>) {
        let frames = self.plan.all_frames();
        let stride = frames.len().div_ceil(Album::MAX_THUMBNAILS);
        let index = frames.iter().position(|f| f.number == number);
        let is_shown = index.is_some_and(|i| i.is_multiple_of(stride.max(1)));
        if self.files.page.is_some()
            && is_shown
            && let Some(small) = thumbnail(image)
        {
            self.lock().album.thumbnails.insert(number, small);
        }
    }

    fn write_sometimes(&self, state: &mut Collected) {
        if state.written.elapsed() >= WRITE_EVERY.max(PAUSE * state.took) {
            // No reason to stop rendering.
            for (flag, error) in self.write(state) {
                tracing::warn!("{flag}: {error}");
            }
        }
    }

    /// Writes the files. Returns the errors of those that cannot be written, each with its flag.
    fn write(&self, state: &mut Collected) -> Vec<(&'static str, OutputError)> {
        let begin = Instant::now();
        state.album.figures.wall_s = self.start.elapsed().as_secs_f64();
        state.album.figures.warnings = self.plan.warnings.list();
        let json = self.files.json.as_ref();
        let json = json.map(|path| self.write_json(path, &state.album.figures));
        let page = self.files.page.as_ref();
        let page = page.map(|folder| self.write_page(folder, &state.album));
        if let Some(all) = &self.files.of_all {
            all.put(&state.album, self.joining.as_ref());
        }
        (state.written, state.took) = (Instant::now(), begin.elapsed());
        let written = [("--stats", json), ("--report", page)].into_iter();
        written
            .filter_map(|(flag, written)| Some((flag, written?.err()?)))
            .collect()
    }

    fn write_json(&self, path: &Path, figures: &Report) -> Result<(), OutputError> {
        let _gate = self.gate(&atomic::folder_of(path));
        let mut figures = figures.clone();
        if let Some(joining) = &self.joining
            && let Some(mut others) = joining.read::<Report>(path)
            && joining.select(&mut others, path)
        {
            figures.join(others.frames);
        }
        let text = serde_json::to_string_pretty(&figures).expect("figures are plain data");
        write_text(path, &(text + "\n"))
    }

    fn write_page(&self, folder: &Path, album: &Album) -> Result<(), OutputError> {
        let _gate = self.gate(folder);
        let (path, mut album) = (folder.join(ALBUM), album.clone());
        if let Some(joining) = &self.joining
            && let Some(mut others) = joining.read::<Album>(&path)
            && joining.select(&mut others.figures, &path)
        {
            album.join(others);
        }
        let text = serde_json::to_string(&album).expect("figures are plain data");
        write_text(&path, &(text + "\n"))?;
        write_text(&folder.join(PAGE), &page(&album))
    }

    /// Keeps other jobs of the sequence from changing files between reading and writing, where this one joins theirs.
    fn gate(&self, folder: &Path) -> Option<FolderGate> {
        self.joining.as_ref().map(|_| FolderGate::close(folder, self.cancel))
    }
}

impl Work {
    fn so_far(counters: &Counters) -> Self {
        Self {
            samples: counters.samples(),
            segments: counters.segments(),
            rays: counters.rays(),
            cpu: memory::cpu_seconds(),
        }
    }
}

impl Observer for Stats<'_> {
    fn event(&self, event: &JobEvent<'_>) {
        if let JobEvent::FrameImage { frame, image } = event {
            return self.keep_thumbnail(*frame, image);
        }
        let mut state = self.lock();
        let state = &mut *state;
        match event {
            JobEvent::FrameStarted { frame, .. } => {
                state.before = Work::so_far(self.counters);
                self.frame(state, *frame);
            }
            JobEvent::FrameRendered { frame, took } => {
                let (before, now) = (state.before, Work::so_far(self.counters));
                let frame = self.frame(state, *frame);
                frame.status = Status::Rendered;
                frame.wall_s = took.as_secs_f64();
                frame.cpu_s = now.cpu.zip(before.cpu).map(|(now, before)| now - before);
                frame.samples = now.samples - before.samples;
                frame.segments = now.segments - before.segments;
                frame.shadow_rays = (now.rays - before.rays).saturating_sub(frame.segments);
                frame.peak_memory_bytes = memory::peak();
            }
            JobEvent::FrameCutShort { frame, samples } => self.frame(state, *frame).samples_per_pixel = Some(*samples),
            JobEvent::FrameSkipped { frame } => self.frame(state, *frame).status = Status::Skipped,
            JobEvent::FrameStale { frame, stale } => self.frame(state, *frame).reason = Some(stale.to_string()),
            JobEvent::FrameFailed(FrameFailure { frame, cause }) => {
                let frame = self.frame(state, *frame);
                frame.status = Status::Failed;
                frame.reason = Some(cause.to_string());
            }
            JobEvent::FrameImage { .. } => {}
            JobEvent::DenoisedFingerprint { frame, fingerprint } => self.frame(state, *frame).set_denoised(fingerprint),
            JobEvent::FileWritten { frame, file } | JobEvent::FrameDenoised { frame, file } => {
                self.frame(state, *frame).files.push(file.display().to_string())
            }
            JobEvent::FrameWritten { frame } => self.frame(state, *frame).status = Status::Written,
        }
        if let JobEvent::FrameSkipped { .. } | JobEvent::FrameFailed(_) | JobEvent::FrameWritten { .. } = event {
            self.write_sometimes(state);
        }
    }
}

/// Several observers of one job.
pub struct Observers<'a>(pub Vec<&'a dyn Observer>);

impl Observer for Observers<'_> {
    fn event(&self, event: &JobEvent<'_>) {
        self.0.iter().for_each(|observer| observer.event(event));
    }
}
