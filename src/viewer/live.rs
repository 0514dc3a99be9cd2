//! The rendering of the view: first a coarse picture, then all pixels with one sample, then more samples.
//!
//! The first picture of a view takes little time and is never cancelled; otherwise a camera in constant motion would show nothing.
//! All later pictures are cancelled as soon as the view changes.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::{
    canvas::Canvas,
    pace::Pace,
    picture::{Picture, Stage, ViewHeader, jpeg},
    seeker::{Seeker, SeekerOfFrame},
    session::Session,
    view::Task,
};
use crate::{
    batch::Fingerprint,
    camera::FrameCamera,
    error::{Blame, Error},
    film::{Film, Window},
    output::{self, FrameImage, png::Png},
    render::{
        Control, Counters, FrameScenes, RenderError, Renderer, SampleBudget, Settings, StillScene, TileResult,
        TileSink, moment_times,
    },
};

/// The quality of JPEG files in motion, and of later or small ones.
const COARSE_QUALITY: u8 = 80;
const FINE_QUALITY: u8 = 92;

/// The most pixels of a small picture.
const SMALL: usize = 100_000;

/// The pause after the first picture of a view. A moving camera has a newer view by then, and the browser draws the first picture
/// with a free processor.
const PAUSE: Duration = Duration::from_millis(25);

/// The least time between two pictures of an unfinished round.
const PART_EVERY: Duration = Duration::from_millis(200);

/// Renders views on `threads` threads until the session stops.
pub fn run(session: &Session, threads: usize) -> Result<(), Error> {
    let pool = build_pool(threads)?;
    let mut view_renderer = ViewRenderer {
        session,
        // The browser draws one picture of a moving camera while the next is rendered.
        first_pool: build_pool(threads.saturating_sub(1).max(1))?,
        renderer: Renderer::new(),
        counters: Counters::default(),
        pace: Pace::default(),
    };
    let (mut next, mut look) = (session.next_task(0), None);
    while let Some(base) = next.as_ref().map(|task| Arc::clone(&task.base)) {
        let mut seeker = Seeker::new(&base);
        while let Some(task) = next.take_if(|task| Arc::ptr_eq(&task.base, &base)) {
            if look.as_ref() != Some(&task.look) {
                view_renderer.pace = Pace::default();
                look = Some(task.look.clone());
            }
            let rendered = pool.install(|| view_renderer.render(&task, &mut seeker));
            session.tell_frame(rendered.err().filter(|error| error.blame() != Blame::Cancelled));
            next = session.next_task(task.view.version);
        }
    }
    Ok(())
}

fn build_pool(threads: usize) -> Result<ThreadPool, Error> {
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("view {i}"))
        .build()
        .map_err(|e| Error::threads("the threads that render the view", &e))
}

/// Renders one view after the other.
struct ViewRenderer<'a> {
    session: &'a Session,
    /// The threads of first pictures: a processor fewer than all.
    first_pool: ThreadPool,
    renderer: Renderer,
    counters: Counters,
    pace: Pace,
}

/// The rendering of one view.
struct ViewJob<'a> {
    session: &'a Session,
    task: &'a Task,
    counters: &'a Counters,
    /// The start of rendering, shifted by the time of pauses.
    begun: Instant,
    /// The counter of rays at the start.
    rays: u64,
}

impl ViewRenderer<'_> {
    fn render(&mut self, task: &Task, seeker: &mut Seeker<'_>) -> Result<(), Error> {
        let mut job = ViewJob {
            session: self.session,
            task,
            counters: &self.counters,
            begun: Instant::now(),
            rays: self.counters.rays(),
        };
        let full = job.full_settings();
        let divisor = self.pace.divisor(full.window.area());
        let coarse = coarse(&full, divisor);
        let Some(camera) = job.camera(&coarse) else {
            return Ok(());
        };
        let canvas = job.canvas(&coarse, &camera)?;
        let scene = seeker.seek(f64::from(task.view.whole_frame()))?;
        let begun = Instant::now();
        let unwatched = Control {
            counters: Some(&self.counters),
            ..Control::default()
        };
        let film = self
            .first_pool
            .install(|| self.film::<StillScene<'_>>(task, (&mut StillScene(scene), &camera), &coarse, &unwatched))?;
        self.pace.learn(coarse.window.area() as u64, begun.elapsed());
        canvas.draw_film(&film);
        let rgb = canvas.rgb();
        let is_small = coarse.window.area() <= SMALL;
        let quality = if is_small { FINE_QUALITY } else { COARSE_QUALITY };
        job.publish_jpeg(Stage::Coarse, 1, &rgb, canvas.size, quality);
        let paused = Instant::now();
        if self.session.waits_for_newer(task.view.version, PAUSE) {
            return Ok(());
        }
        job.begun += paused.elapsed();
        if divisor == 1 && full.samples.max == 1 && seeker.is_still() {
            // The picture has all its pixels and all its samples.
            job.publish_final(&film, &camera);
            return Ok(());
        }
        self.refine(&job, seeker, full, (&rgb, canvas.size))
    }

    /// Renders the full resolution, in rounds.
    fn refine(
        &self,
        job: &ViewJob<'_>,
        seeker: &mut Seeker<'_>,
        mut settings: Settings,
        (rgb, size): (&[u8], [u32; 2]),
    ) -> Result<(), Error> {
        let task = job.task;
        let Some(camera) = job.camera(&settings) else {
            return Ok(());
        };
        let canvas = job.canvas(&settings, &camera)?;
        canvas.fill(rgb, size);
        let sink = Rounds {
            job,
            canvas: &canvas,
            published: Mutex::new(Instant::now()),
        };
        let control = Control {
            cancel: Some(&task.cancel),
            counters: Some(&self.counters),
            sink: Some(&sink),
            ..Control::default()
        };
        let mut scenes = SeekerOfFrame {
            seeker,
            number: task.view.whole_frame(),
            camera: &camera,
        };
        if camera.duration() > 0.0 && !scenes.is_still(moment_times(&settings, &camera)) {
            // The bits of a blurred picture depend on its rounds, so after a first one they are those of the job.
            settings.samples = SampleBudget::fixed(1);
            self.film(task, (&mut scenes, &camera), &settings, &control)?;
            settings.samples = task.plan.picture.settings.samples;
        }
        let film = self.film(task, (&mut scenes, &camera), &settings, &control)?;
        job.publish_final(&film, &camera);
        Ok(())
    }

    fn film<S: FrameScenes>(
        &self,
        task: &Task,
        (scenes, camera): (&mut S, &FrameCamera),
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Film, S::Error> {
        let integrator = task.plan.picture.integrator.as_dyn();
        self.renderer
            .render_moving(scenes, camera, integrator, settings, control)
    }
}

impl ViewJob<'_> {
    /// The settings with which the job renders the frame, at the scale of the look, in rounds.
    fn full_settings(&self) -> Settings {
        let Task { plan, look, view, .. } = self.task;
        let resolution = plan.picture.settings.resolution.map(|side| side.div_ceil(look.scale));
        Settings {
            resolution,
            window: Window::full(resolution),
            samples: SampleBudget {
                min: 1,
                ..plan.picture.settings.samples
            },
            noise_frame: plan.picture.seed_mode.frame(view.whole_frame()),
            ..plan.picture.settings.clone()
        }
    }

    fn camera(&self, settings: &Settings) -> Option<FrameCamera> {
        // The session refuses invalid cameras.
        let Task { base, view, .. } = self.task;
        view.frame_camera(base, settings.resolution).ok()
    }

    fn canvas(&self, settings: &Settings, camera: &FrameCamera) -> Result<Canvas, RenderError> {
        let Task { plan, base, .. } = self.task;
        Ok(base.canvas(plan, settings, camera.fills_film())?)
    }

    fn publish_jpeg(&self, stage: Stage, samples: u32, rgb: &[u8], size: [u32; 2], quality: u8) {
        let file = jpeg(rgb, size, quality);
        if !file.is_empty() {
            self.publish(stage, samples, size, "image/jpeg", &file);
        }
    }

    /// Publishes the final picture, with the bytes of the job's file.
    fn publish_final(&self, film: &Film, camera: &FrameCamera) {
        let Task { plan, base, .. } = self.task;
        let frame = self.task.view.whole_frame();
        let settings = self.full_settings();
        let fingerprint = Fingerprint::new(plan, &settings, base.inputs, (frame, camera));
        let metadata = fingerprint.metadata(plan, frame, camera);
        let image = FrameImage {
            film,
            shown: plan.picture.shown,
            coverage: base.coverage(plan, plan.fills_film && camera.fills_film()),
            metadata: &metadata,
        };
        // Encoding a non-empty picture into memory cannot fail.
        if let Ok((file, _)) = output::encode(&Png, &image, plan.files.encoding) {
            let size = film.resolution;
            self.publish(
                Stage::Final,
                plan.picture.settings.samples.max,
                size,
                "image/png",
                &file,
            );
        }
    }

    fn publish(&self, stage: Stage, samples: u32, [width, height]: [u32; 2], mime: &'static str, file: &[u8]) {
        let view = &self.task.view;
        let seconds = self.begun.elapsed().as_secs_f64();
        let rays = self.counters.rays() - self.rays;
        let lens = view.lens(&self.task.base);
        let lens = match &view.path {
            Some(path) => path.at(view.frame).map(|state| state.apply(&lens)),
            None => view.camera.state(view.frame).map(|state| state.apply(&lens)),
        };
        let header = ViewHeader {
            kind: "view",
            version: view.version,
            client: view.client,
            seq: view.seq,
            stage,
            mime,
            width,
            height,
            samples,
            of: self.task.plan.picture.settings.samples.max,
            ms: 1e3 * seconds,
            rays_per_second: rays as f64 / seconds,
            frame: view.frame,
            on_path: view.path.is_some(),
            camera: view.camera,
            lens: lens.map(|lens| lens.parameters().into()).unwrap_or_default(),
        };
        self.session
            .pictures
            .send_replace(Some(Picture::of_view(&header, file).into()));
    }
}

/// Publishes pictures of finished tiles and rounds.
struct Rounds<'a> {
    job: &'a ViewJob<'a>,
    canvas: &'a Canvas,
    published: Mutex<Instant>,
}

impl TileSink for Rounds<'_> {
    fn tile(&self, tile: &TileResult<'_>) {
        let progress = self.canvas.draw(tile);
        if self.job.task.cancel.is_cancelled() {
            return;
        }
        let is_last = progress.samples == self.job.task.plan.picture.settings.samples.max;
        let stage = match (progress.is_complete, is_last) {
            // The final picture follows.
            (true, true) => return,
            (true, false) => Stage::Round,
            (false, _) => Stage::Part,
        };
        {
            let mut published = self.published.lock().unwrap_or_else(PoisonError::into_inner);
            if stage == Stage::Part && published.elapsed() < PART_EVERY {
                return;
            }
            *published = Instant::now();
        }
        let (rgb, size) = (self.canvas.rgb(), self.canvas.size);
        self.job.publish_jpeg(stage, progress.samples, &rgb, size, FINE_QUALITY);
    }
}

/// The settings of a picture with one sample at a lower resolution.
fn coarse(full: &Settings, divisor: u32) -> Settings {
    let resolution = full.resolution.map(|side| side.div_ceil(divisor));
    Settings {
        resolution,
        window: Window::full(resolution),
        samples: SampleBudget::fixed(1),
        filter: full.filter.clone().filter(|_| divisor == 1 && full.samples.max == 1),
        ..full.clone()
    }
}
