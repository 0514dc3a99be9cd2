//! Rendering a plan: one thread's worth of work writes a frame while all others render the next.

use std::{
    path::Path,
    sync::mpsc::{Receiver, SyncSender, sync_channel},
    time::{Duration, Instant},
};

use rayon::ThreadPoolBuilder;

use super::{CameraRig, Existing, Plan, PlannedFrame, Summary, sidecars};
use crate::{
    error::Error,
    film::Film,
    output::{self, Coverage, FrameImage, OutputError, WriteReport},
    render::{Control, Counters, RenderError, Renderer},
    scene::Scene,
};

/// Told what a job does, as it does it.
pub trait Observer: Sync {
    /// Frame `number` starts, the `index`th of `total` from 0.
    fn frame_started(&self, number: i32, index: usize, total: usize);
    /// It is rendered; its files are not yet written.
    fn frame_rendered(&self, number: i32, took: Duration);
    /// Its files are whole already.
    fn frame_skipped(&self, number: i32);
    /// A file is on disk.
    fn file_written(&self, number: i32, path: &Path);
    /// All files of the frame are on disk.
    fn frame_written(&self, number: i32);
}

/// The most threads that encode a file; a disk is no faster with more.
const MAX_ENCODERS: usize = 16;

/// A rendered frame on its way to disk.
struct Finished<'a> {
    frame: &'a PlannedFrame,
    film: Film,
}

/// Renders all frames of `plan` on the threads of the current rayon pool.
///
/// The folders of the files exist: [`Job::run`](super::Job::run) makes them and checks the places of the files first.
///
/// At most one finished frame waits while another is written. A disk that fails ends the job; whatever happens, a file
/// under its own name is whole.
pub fn run(plan: &Plan, scene: &Scene, observer: &dyn Observer, control: &Control<'_>) -> Result<Summary, Error> {
    let own_counters = Counters::default();
    let counters = control.counters.unwrap_or(&own_counters);
    let control = Control {
        counters: Some(counters),
        ..*control
    };
    let start = Instant::now();
    let (send, receive) = sync_channel(1);
    let coverage = plan.coverage(scene, plan.frames.iter().all(|f| f.camera.fills_film()));
    // Of its own: a thread that renders may have to wait for the writer.
    let encoders = ThreadPoolBuilder::new()
        .num_threads(rayon::current_num_threads().min(MAX_ENCODERS))
        .thread_name(|i| format!("write {i}"))
        .build()
        .map_err(|cause| Error::threads("the threads that write files", &cause))?;
    let mut written = Ok(0);
    let rendered = encoders.in_place_scope(|scope| {
        scope.spawn(|_| written = write_all(plan, coverage, receive, observer));
        let rendered = render_all(plan, scene, observer, &control, &send);
        drop(send);
        rendered
    });
    // A file that cannot be written is why rendering stopped, so it speaks first.
    let clamped = written?;
    let mut summary = Summary { clamped, ..rendered? };
    sidecars::write(plan, scene)?;
    summary.wall = start.elapsed();
    summary.rays = counters.rays();
    summary.samples = counters.samples();
    Ok(summary)
}

fn render_all<'a>(
    plan: &'a Plan,
    scene: &Scene,
    observer: &dyn Observer,
    control: &Control<'_>,
    send: &SyncSender<Finished<'a>>,
) -> Result<Summary, Error> {
    let mut summary = Summary::default();
    let (renderer, rig) = (Renderer::new(), CameraRig::new(plan, scene));
    for (index, frame) in plan.frames.iter().enumerate() {
        if plan.existing == Existing::Skip && frame.is_on_disk() {
            observer.frame_skipped(frame.number);
            summary.skipped += 1;
            continue;
        }
        observer.frame_started(frame.number, index, plan.frames.len());
        let start = Instant::now();
        let camera = rig.camera(plan, frame);
        let film = plan
            .render_frame(&renderer, scene, (frame, &camera), control)
            .map_err(|e| match e {
                RenderError::Cancelled(cancelled) => Error::Cancelled(cancelled),
                RenderError::Pass(unknown) => Error::Usage(unknown.to_string()),
            })?;
        let took = start.elapsed();
        observer.frame_rendered(frame.number, took);
        let invalid = control.counters.map(Counters::take_invalid).unwrap_or_default();
        if invalid.count > 0 {
            summary.invalid.push((frame.number, invalid));
        }
        summary.frame_times.push(took);
        summary.rendered += 1;
        if send.send(Finished { frame, film }).is_err() {
            // The writer has given up; its error says why.
            break;
        }
    }
    Ok(summary)
}

/// Writes frames as they come. Returns the number of values that did not fit into their files.
fn write_all(
    plan: &Plan,
    coverage: Coverage,
    frames: Receiver<Finished<'_>>,
    observer: &dyn Observer,
) -> Result<u64, OutputError> {
    let mut clamped = 0;
    for Finished { frame, film } in frames {
        let image = FrameImage {
            film: &film,
            shown: plan.shown,
            coverage,
            metadata: &plan.metadata(frame.number),
        };
        for file in &frame.files {
            let report: WriteReport = output::write(&file.path, file.format, &image, plan.encoding)?;
            clamped += report.clamped + report.nans;
            observer.file_written(frame.number, &file.path);
        }
        observer.frame_written(frame.number);
    }
    Ok(clamped)
}
