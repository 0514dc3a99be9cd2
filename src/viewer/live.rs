//! The rendering of the view: a coarse picture at once, then all pixels with one sample, then more and more.
//!
//! The first picture of a view is never cancelled, because it is there soon; otherwise a camera that never rests would show
//! nothing. Everything after it is cancelled as soon as the view changes.

use std::{
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

use rayon::ThreadPoolBuilder;

use super::{
    canvas::Canvas,
    pace::Pace,
    picture::{Picture, Stage, ViewHeader, jpeg},
    session::{Session, Task},
};
use crate::{
    batch::Fingerprint,
    camera::FrameCamera,
    error::Error,
    film::{Film, Window},
    output::{self, FrameImage, png::Png},
    render::{Control, Counters, RenderError, Renderer, SampleBudget, Settings, TileResult, TileSink},
};

/// The quality of JPEG files in motion, and of those that stay for a while or are small.
const COARSE_QUALITY: u8 = 80;
const FINE_QUALITY: u8 = 92;

/// The most pixels of a small picture.
const SMALL: usize = 100_000;

/// The time between the first picture of a view and the work on the next. A camera that moves is at another place by then, and
/// the browser has drawn the first picture without having to share the processors.
const PAUSE: Duration = Duration::from_millis(25);

/// The least time between two pictures of a round that is under way.
const PART_EVERY: Duration = Duration::from_millis(200);

/// Renders views on `threads` threads until the session stops.
pub fn run(session: &Session, threads: usize) -> Result<(), Error> {
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("view {i}"))
        .build()
        .map_err(|e| Error::threads("the threads that render the view", &e))?;
    let mut artist = Artist {
        session,
        renderer: Renderer::new(),
        counters: Counters::default(),
        pace: Pace::default(),
    };
    let (mut version, mut look) = (0, None);
    while let Some(task) = session.next_task(version) {
        version = task.view.version;
        if look.as_ref() != Some(&task.look) {
            artist.pace = Pace::default();
            look = Some(task.look.clone());
        }
        match pool.install(|| artist.render(&task)) {
            Ok(()) | Err(RenderError::Cancelled(_)) => {}
            // A plan has no pass that its scene has not.
            Err(error @ RenderError::Pass(_)) => tracing::error!("{error}"),
        }
    }
    Ok(())
}

/// Renders one view after the other.
struct Artist<'a> {
    session: &'a Session,
    renderer: Renderer,
    counters: Counters,
    pace: Pace,
}

/// The rendering of one view.
struct Sitting<'a> {
    session: &'a Session,
    task: &'a Task,
    counters: &'a Counters,
    /// Later by the time that was spent waiting.
    begun: Instant,
    /// The rays before it.
    rays: u64,
}

impl Artist<'_> {
    fn render(&mut self, task: &Task) -> Result<(), RenderError> {
        let mut sitting = Sitting {
            session: self.session,
            task,
            counters: &self.counters,
            begun: Instant::now(),
            rays: self.counters.rays(),
        };
        let full = sitting.full_settings();
        let divisor = self.pace.divisor(full.window.area());
        let coarse = coarse(&full, divisor);
        let Some(camera) = sitting.camera(&coarse) else {
            return Ok(());
        };
        let canvas = Canvas::new(&task.plan, &coarse, &self.session.base.scene, camera.fills_film())?;
        let begun = Instant::now();
        let unwatched = Control {
            counters: Some(&self.counters),
            ..Control::default()
        };
        let film = self.film(task, &camera, &coarse, &unwatched)?;
        self.pace.learn(coarse.window.area() as u64, begun.elapsed());
        canvas.draw_film(&film);
        let rgb = canvas.rgb();
        let is_small = coarse.window.area() <= SMALL;
        let quality = if is_small { FINE_QUALITY } else { COARSE_QUALITY };
        sitting.publish_jpeg(Stage::Coarse, 1, &rgb, canvas.size, quality);
        let paused = Instant::now();
        if self.session.waits_for_newer(task.view.version, PAUSE) {
            return Ok(());
        }
        sitting.begun += paused.elapsed();
        if divisor == 1 && full.samples.max == 1 {
            // The picture has all its pixels and all its samples.
            sitting.publish_final(&film, &camera);
            return Ok(());
        }
        self.refine(&sitting, full, (&rgb, canvas.size))
    }

    /// Renders the full resolution, in rounds.
    fn refine(
        &self,
        sitting: &Sitting<'_>,
        settings: Settings,
        (rgb, size): (&[u8], [u32; 2]),
    ) -> Result<(), RenderError> {
        let task = sitting.task;
        let Some(camera) = sitting.camera(&settings) else {
            return Ok(());
        };
        let canvas = Canvas::new(&task.plan, &settings, &self.session.base.scene, camera.fills_film())?;
        canvas.fill(rgb, size);
        let sink = Rounds {
            sitting,
            canvas: &canvas,
            published: Mutex::new(Instant::now()),
        };
        let control = Control {
            cancel: Some(&task.cancel),
            counters: Some(&self.counters),
            sink: Some(&sink),
            ..Control::default()
        };
        let film = self.film(task, &camera, &settings, &control)?;
        sitting.publish_final(&film, &camera);
        Ok(())
    }

    fn film(
        &self,
        task: &Task,
        camera: &FrameCamera,
        settings: &Settings,
        control: &Control<'_>,
    ) -> Result<Film, RenderError> {
        let integrator = task.plan.picture.integrator.as_dyn();
        self.renderer
            .render(&self.session.base.scene, camera, integrator, settings, control)
    }
}

impl Sitting<'_> {
    /// The settings with which the job renders the frame, at the scale of the look, in rounds.
    fn full_settings(&self) -> Settings {
        let Task { plan, look, view, .. } = self.task;
        let resolution = plan.picture.settings.resolution.map(|side| side.div_ceil(look.scale));
        // Frames of a view lie within the limits of paths, which are less than 2^31.
        let frame = i32::try_from(view.frame).unwrap_or_default();
        Settings {
            resolution,
            window: Window::full(resolution),
            samples: SampleBudget {
                min: 1,
                ..plan.picture.settings.samples
            },
            noise_frame: plan.picture.seed_mode.frame(frame),
            ..plan.picture.settings.clone()
        }
    }

    fn camera(&self, settings: &Settings) -> Option<FrameCamera> {
        // The session lets no other camera in.
        self.task
            .view
            .frame_camera(&self.session.base.lens, settings.resolution)
            .ok()
    }

    fn publish_jpeg(&self, stage: Stage, samples: u32, rgb: &[u8], size: [u32; 2], quality: u8) {
        let file = jpeg(rgb, size, quality);
        if !file.is_empty() {
            self.publish(stage, samples, size, "image/jpeg", &file);
        }
    }

    /// Publishes the file that the job would write.
    fn publish_final(&self, film: &Film, camera: &FrameCamera) {
        let plan = &self.task.plan;
        let frame = i32::try_from(self.task.view.frame).unwrap_or_default();
        let settings = self.full_settings();
        let fingerprint = Fingerprint::new(plan, &settings, self.session.base.inputs, (frame, camera));
        let metadata = fingerprint.metadata(plan, frame, camera);
        let image = FrameImage {
            film,
            shown: plan.picture.shown,
            coverage: plan.coverage(&self.session.base.scene, camera.fills_film()),
            metadata: &metadata,
        };
        // Memory takes every byte of a picture that has pixels.
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
        let lens = self.session.base.lens;
        let lens = match &view.path {
            Some(path) => path.at(view.frame as f64).map(|state| state.apply(&lens)),
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

/// Publishes pictures as tiles and rounds get ready.
struct Rounds<'a> {
    sitting: &'a Sitting<'a>,
    canvas: &'a Canvas,
    published: Mutex<Instant>,
}

impl TileSink for Rounds<'_> {
    fn tile(&self, tile: &TileResult<'_>) {
        let progress = self.canvas.draw(tile);
        if self.sitting.task.cancel.is_cancelled() {
            return;
        }
        let is_last = progress.samples == self.sitting.task.plan.picture.settings.samples.max;
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
        self.sitting
            .publish_jpeg(stage, progress.samples, &rgb, size, FINE_QUALITY);
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
