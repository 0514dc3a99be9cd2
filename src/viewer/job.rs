//! The batch job of a page, in this process, with its own threads, scene and files.

use std::{
    panic::{self, AssertUnwindSafe},
    sync::{Arc, Mutex, MutexGuard},
    thread,
    time::{Duration, Instant},
};

use rayon::ThreadPoolBuilder;

use super::{
    canvas::Canvas,
    message::JobFacts,
    picture::{JobHeader, Picture, jpeg},
    session::{RunningJob, Session},
};
use crate::{
    batch::{Job, JobEvent, Observer, Plan, Request, Summary},
    error::{Blame, Error},
    render::{Cancel, Control, Counters, TileResult, TileSink},
};

/// The least time between two pictures of a job, and between two reports of its progress.
const SHOW_EVERY: Duration = Duration::from_millis(250);

const QUALITY: u8 = 85;

/// Starts the job of the page's path.
///
/// # Errors
/// A job is running, or the path was not saved.
pub fn start(session: &Arc<Session>) -> Result<(), String> {
    let request = session.job_request()?;
    let mut running = session.running_job();
    if running.as_ref().is_some_and(|job| !job.thread.is_finished()) {
        return Err("a job is running already".to_owned());
    }
    let cancel = Arc::new(Cancel::default());
    let work = {
        let (session, cancel) = (Arc::clone(session), Arc::clone(&cancel));
        move || {
            session.job.send_replace(JobFacts {
                t: "job",
                state: "loading",
                ..JobFacts::default()
            });
            let done = panic::catch_unwind(AssertUnwindSafe(|| run(&session, &request, &cancel)));
            finish(&session, done);
        }
    };
    let thread = thread::Builder::new().name("job".to_owned()).spawn(work);
    let thread = thread.map_err(|e| Error::threads("the thread of the job", &e).to_string())?;
    *running = Some(RunningJob { cancel, thread });
    Ok(())
}

fn run(session: &Session, request: &Request, cancel: &Cancel) -> Result<Summary, Error> {
    let pool = ThreadPoolBuilder::new()
        .num_threads(session.source.threads)
        .thread_name(|i| format!("job {i}"))
        .build()
        .map_err(|e| Error::threads("the threads of the job", &e))?;
    pool.install(|| {
        let job = Job::open(&session.source.scene, request)?;
        let scene = job.load()?;
        let counters = Counters::default();
        let watch = Watch::new(session, &job.plan, &counters)?;
        let control = Control {
            cancel: Some(cancel),
            counters: Some(&counters),
            sink: Some(&watch),
            ..Control::default()
        };
        job.run(scene, &watch, &control)
    })
}

fn finish(session: &Session, done: thread::Result<Result<Summary, Error>>) {
    session.job.send_modify(|facts| {
        (facts.state, facts.text) = match done {
            Ok(Ok(summary)) => ("done", done_text(summary.rendered, summary.wall)),
            Ok(Err(error)) if error.blame() == Blame::Cancelled => ("cancelled", String::new()),
            Ok(Err(error)) => ("failed", error.messages().join("\n")),
            Err(_) => ("failed", "a fault of the program: see its output".to_owned()),
        };
    });
}

/// The number of frames and the time of a job that is done.
fn done_text(frames: usize, took: Duration) -> String {
    let end = if frames == 1 { "" } else { "s" };
    format!("{frames} frame{end} in {:.1} s", took.as_secs_f64())
}

/// Observes a job and reports to the pages.
struct Watch<'a> {
    session: &'a Session,
    plan: &'a Plan,
    counters: &'a Counters,
    now: Mutex<Now>,
}

struct Now {
    canvas: Arc<Canvas>,
    frame: i32,
    samples_before: u64,
    shown: Instant,
}

impl<'a> Watch<'a> {
    fn new(session: &'a Session, plan: &'a Plan, counters: &'a Counters) -> Result<Self, Error> {
        Ok(Self {
            now: Mutex::new(Now {
                canvas: Arc::new(canvas(session, plan)?),
                frame: 0,
                samples_before: 0,
                shown: Instant::now(),
            }),
            session,
            plan,
            counters,
        })
    }

    fn lock(&self) -> MutexGuard<'_, Now> {
        self.now.lock().expect("no thread panics while it watches a job")
    }

    fn start_frame(&self, number: i32, total: usize) {
        // The plan's canvas was made before, so another one can be made.
        let canvas = canvas(self.session, self.plan).ok();
        {
            let mut now = self.lock();
            now.canvas = canvas.map_or_else(|| Arc::clone(&now.canvas), Arc::new);
            (now.frame, now.samples_before) = (number, self.counters.settled());
        }
        self.session.job.send_modify(|facts| {
            (facts.state, facts.frame, facts.frames, facts.fraction) = ("running", number, total, 0.0);
        });
    }

    fn show(&self, canvas: &Canvas, frame: i32, is_complete: bool) {
        let file = jpeg(&canvas.rgb(), canvas.size, QUALITY);
        if file.is_empty() {
            return;
        }
        let [width, height] = canvas.size;
        let header = JobHeader {
            kind: "job",
            mime: "image/jpeg",
            width,
            height,
            frame,
            is_complete,
        };
        let picture = Picture::of_job(&header, &file);
        self.session.job_pictures.send_replace(Some(picture.into()));
    }

    /// The fraction of the frame that is rendered.
    fn fraction(&self, now: &Now) -> f64 {
        let all = self.plan.picture.settings.max_samples() as f64;
        let done = self.counters.settled() - now.samples_before;
        (done as f64 / all).min(1.0)
    }
}

fn canvas(session: &Session, plan: &Plan) -> Result<Canvas, Error> {
    let fills_film = plan.frames.iter().all(|frame| frame.camera.fills_film());
    // The scene of the view has the same light groups as that of the job.
    let canvas = session.base().canvas(plan, &plan.picture.settings, fills_film);
    canvas.map_err(|unknown| Error::Usage(unknown.to_string()))
}

impl TileSink for Watch<'_> {
    fn tile(&self, tile: &TileResult<'_>) {
        let (canvas, frame) = {
            let now = self.lock();
            (Arc::clone(&now.canvas), now.frame)
        };
        let is_complete = canvas.draw(tile).is_complete;
        let fraction = {
            let mut now = self.lock();
            if !is_complete && now.shown.elapsed() < SHOW_EVERY {
                return;
            }
            now.shown = Instant::now();
            self.fraction(&now)
        };
        self.show(&canvas, frame, is_complete);
        self.session.job.send_modify(|facts| facts.fraction = fraction);
    }
}

impl Observer for Watch<'_> {
    fn event(&self, event: &JobEvent<'_>) {
        match event {
            JobEvent::FrameStarted { frame, total, .. } => self.start_frame(*frame, *total),
            JobEvent::FrameSkipped { .. } | JobEvent::FrameWritten { .. } => {
                self.session.job.send_modify(|facts| facts.done += 1);
            }
            JobEvent::FileWritten { file, .. } => {
                let text = file.display().to_string();
                self.session.job.send_modify(|facts| facts.text = text);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_of_one_frame_is_done_with_1_frame() {
        let texts = [0, 1, 2].map(|frames| done_text(frames, Duration::from_millis(300)));
        assert_eq!(texts, ["0 frames in 0.3 s", "1 frame in 0.3 s", "2 frames in 0.3 s"]);
    }
}
