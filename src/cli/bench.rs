//! `batch-render bench`.

use std::{
    io::{self, IsTerminal},
    path::{Path, PathBuf},
    sync::Arc,
};

use super::{bench_args::BenchArgs, log::LastWarnings, progress::say, threads::threads};
use anyhow::Context;
use batch_render::{
    accel::BuildOptions,
    batch::{CameraRig, Fingerprint, Job, PlannedFrame, Request, Scenes, time_in_frames},
    bench::{self, BenchObserver, BenchOptions, Buffers, Subject},
    camera::FrameCamera,
    describe::Overrides,
    error::Error,
    film::Film,
    geometry::Geometry,
    output::{EncodeError, FrameImage, atomic},
    render::{Control, SceneTime},
    simd::Isa,
};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// The page in the folder of the report.
const PAGE: &str = "bench.html";

/// The files that are written.
fn files(args: &BenchArgs) -> Vec<PathBuf> {
    let page = args.report.as_ref().map(|folder| folder.join(PAGE));
    args.json.iter().cloned().chain(page).collect()
}

fn write(path: &Path, text: &str) -> Result<(), Error> {
    Ok(atomic::write(path, |out| Ok(out.write_all(text.as_bytes())?))?)
}

/// Refuses a file that cannot be written, or that the job reads.
fn check(args: &BenchArgs, job: &Job) -> Result<(), Error> {
    job.compare_files()?;
    Ok(files(args).iter().try_for_each(|file| atomic::check(file))?)
}

/// Measures and reports.
pub fn run(args: &BenchArgs, simd: Isa, quiet: bool) -> anyhow::Result<()> {
    args.settings.refuse_stream()?;
    if args.picture {
        picture(args, simd)
    } else if args.settings.overrides.paths().next().is_none() {
        rays(args, simd, quiet)
    } else {
        let message =
            "the flags of the picture need --picture: without it, rays of the bench's own picture are measured";
        Err(Error::Usage(message.to_owned()).into())
    }
}

/// Measures the stages of the scene's own picture.
fn picture(args: &BenchArgs, simd: Isa) -> anyhow::Result<()> {
    let request = Request {
        overrides: args.settings.overrides.clone(),
        camera_path: args.frames.clone(),
        range: args.range.clone(),
        accel: BuildOptions {
            simd,
            ..BuildOptions::default()
        },
        files_of_caller: files(args),
        ..Request::default()
    };
    let _last = LastWarnings(request.warnings.clone());
    let report = threads(args.threads)?.install(|| {
        let job = Job::open(&args.scene, &request)?;
        let loaded = job.load()?;
        check(args, &job)?;
        let mut scenes = job.scenes(job.build(loaded)?);
        let frame = job.plan.frames.first().context("there is no frame to render")?;
        let mut subject = FirstFrame {
            camera: CameraRig::new(&job.plan, scenes.seek(job.plan.first_frame)?).camera(&job.plan, frame),
            fingerprint: Fingerprint::of_frame(&job.plan, job.inputs(), frame),
            job: &job,
            scenes,
            frame,
        };
        let settings = &job.plan.picture.settings;
        bench::picture::measure(&job.desc.name(), simd, settings, &mut subject, args.repetitions)
    })?;
    say(report.to_text().trim_end());
    match &args.json {
        Some(file) => Ok(write(file, &report.to_json())?),
        None => Ok(()),
    }
}

/// The first frame of a job.
struct FirstFrame<'a> {
    job: &'a Job,
    scenes: Scenes<'a>,
    frame: &'a PlannedFrame,
    camera: FrameCamera,
    fingerprint: Fingerprint,
}

impl Subject for FirstFrame<'_> {
    type Error = anyhow::Error;

    fn render(&mut self, control: &Control<'_>) -> anyhow::Result<Film> {
        Ok(self.job.render_frame(&mut self.scenes, 0, control)?)
    }

    fn encode(&self, film: &Film) -> Result<(), EncodeError> {
        let plan = &self.job.plan;
        let background = &self.scenes.current().shading.background;
        let image = FrameImage {
            film,
            shown: plan.picture.shown,
            coverage: plan.coverage(background, self.camera.fills_film()),
            metadata: &self.fingerprint.metadata(plan, self.frame.number, &self.camera),
        };
        for file in &self.frame.files {
            file.format.encode(&image, plan.files.encoding, &mut io::sink())?;
        }
        Ok(())
    }
}

/// Measures all accelerators with the rays of a scene.
fn rays(args: &BenchArgs, simd: Isa, quiet: bool) -> anyhow::Result<()> {
    let side = bench::SIDE;
    let request = Request {
        overrides: Overrides::default()
            .with("render.width", side)
            .with("render.height", side)
            .with("render.samples", 1),
        accel: BuildOptions {
            simd,
            ..BuildOptions::default()
        },
        files_of_caller: files(args),
        ..Request::default()
    };
    let _last = LastWarnings(request.warnings.clone());
    let pool = threads(args.threads)?;
    let job = pool.install(|| Job::open(&args.scene, &request))?;
    let frame = job
        .plan
        .frames
        .first()
        .context("there is no frame to take the camera from")?;
    let progress = BenchProgress::new(quiet);
    let report = pool.install(|| {
        let loaded = job.load()?;
        check(args, &job)?;
        let mut scenes = job.scenes(job.build(loaded)?);
        let scene = scenes.seek(time_in_frames(frame.number, &frame.camera, SceneTime::OPENING))?;
        let buffers = Buffers::new(scene, &frame.camera.camera(0.0));
        let geometry = contest(scene.geometry.accel.geometry(), args.embree.as_deref());
        let options = BenchOptions {
            scene: job.desc.name(),
            simd,
            embree: args.embree.clone(),
            repetitions: args.repetitions.get(),
            builds: args.builds.into(),
        };
        bench::run(&geometry, &buffers, &options, &progress).map_err(anyhow::Error::from)
    })?;
    progress.finish();
    say(report.to_text().trim_end());
    if let Some(file) = &args.json {
        write(file, &report.to_json())?;
    }
    if let Some(folder) = &args.report {
        let file = folder.join(PAGE);
        write(&file, &bench::page(&report))?;
        say(&format!("wrote {}", file.display()));
    }
    Ok(())
}

/// The geometry that all accelerators trace. With Embree it is the triangles without instances, because only those are compared.
fn contest(geometry: &Arc<Geometry>, embree: Option<&Path>) -> Arc<Geometry> {
    if embree.is_none() || (geometry.shapes.is_empty() && geometry.instances.is_empty()) {
        return Arc::clone(geometry);
    }
    if !geometry.shapes.is_empty() {
        tracing::warn!(
            "Embree is given triangles only: {} other shapes are left out for all",
            geometry.shapes.len()
        );
    }
    if !geometry.instances.is_empty() {
        tracing::warn!(
            "Embree is given triangles only: {} instances are copies for all",
            geometry.instances.len()
        );
    }
    Arc::new(Geometry {
        shapes: Vec::new(),
        ..geometry.without_instances()
    })
}

/// A bar on a terminal, nothing elsewhere.
struct BenchProgress(ProgressBar);

impl BenchProgress {
    fn new(quiet: bool) -> Self {
        let target = if quiet || !std::io::stdout().is_terminal() {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stdout()
        };
        let bar = ProgressBar::with_draw_target(Some(1), target);
        let style = ProgressStyle::with_template("[{bar:30}] {pos}/{len}  {elapsed} elapsed  {wide_msg}");
        bar.set_style(style.expect("the template is a constant").progress_chars("=> "));
        Self(bar)
    }

    fn finish(self) {
        self.0.finish_and_clear();
    }
}

impl BenchObserver for BenchProgress {
    fn step(&self, done: usize, total: usize, what: &str) {
        self.0.set_length(total as u64);
        self.0.set_position(done as u64);
        self.0.set_message(what.to_owned());
    }
}
