//! Rendering a plan: a thread writes frames ([`writing`](super::writing)) while all others render the next.

use std::{
    sync::mpsc::{SyncSender, sync_channel},
    time::Instant,
};

use rayon::ThreadPoolBuilder;

use super::{
    CameraRig, Existing, Fingerprint, FrameError, FrameFailure, JobEvent, Observer, OnFailure, Plan, PlannedFrame,
    Scenes, StaleReason, Summary, Survey,
    frame_scenes::{Failed, ScenesOfFrame},
    products::{labels::Labels, sidecars},
    resume::checkpoint,
    resume::failure,
    resume::frame_interrupts::FrameInterrupts,
    sight,
    writing::{Finished, WriteSummary, write_all},
};
use crate::{
    error::Error,
    film::Film,
    math::sorting,
    output::{Coverage, atomic},
    render::{Control, Counters, Interrupts, Renderer},
    warnings::WarningKind,
};

/// The most threads that encode a file; a disk is no faster with more.
const MAX_ENCODERS: usize = 16;

/// The first frames of a job, which are looked at for faults of the whole scene.
const JUDGED_FRAMES: u32 = 10;

/// Renders all frames of `plan` on the threads of the current rayon pool.
///
/// The folders of the files exist: [`Job::run`](super::Job::run) makes them and checks the places of the files first.
///
/// At most one finished frame waits while another is written, or a few small ones. A frame that fails alone is left out, and
/// the summary tells, unless the plan says otherwise; a disk that is full or read-only ends the job. Whatever happens, a
/// file under its own name is whole.
pub fn run(
    plan: &Plan,
    scenes: &mut Scenes<'_>,
    survey: &Survey,
    observer: &dyn Observer,
    control: &Control<'_>,
) -> Result<Summary, Error> {
    let own_counters = Counters::default();
    let counters = control.counters.unwrap_or(&own_counters);
    let control = Control {
        counters: Some(counters),
        ..*control
    };
    let start = Instant::now();
    let (send, receive) = sync_channel(1);
    let coverage = plan.coverage_of_all(&scenes.current().shading.background);
    let rig = CameraRig::new(plan, scenes.seek(plan.first_frame)?);
    // Of its own: a thread that renders may have to wait for the writer.
    let encoders = ThreadPoolBuilder::new()
        .num_threads(rayon::current_num_threads().min(MAX_ENCODERS))
        .thread_name(|i| format!("write {i}"))
        .build()
        .map_err(|cause| Error::threads("the threads that write files", &cause))?;
    let mut written = Ok(WriteSummary::default());
    let mut labels = Labels::new(plan);
    let rendered = encoders.in_place_scope(|scope| {
        scope.spawn(|_| written = write_all(plan, coverage, receive, observer));
        let rendered = render_all(
            (plan, &rig),
            (scenes, &mut labels),
            (survey, coverage),
            (observer, &control),
            &send,
        );
        drop(send);
        rendered
    });
    // A file that cannot be written is why rendering stopped, so it speaks first.
    let WriteSummary {
        clamped,
        written,
        done,
        failures,
    } = written?;
    let (rendered, skipped) = rendered?;
    let mut summary = Summary {
        clamped,
        written,
        ..rendered
    };
    summary.failures.extend(failures);
    sorting::sort_by_key(&mut summary.failures, |failure| failure.frame);
    sidecars::write(
        (plan, survey.inputs),
        (&rig, scenes.current(), labels),
        &done.into_iter().chain(skipped).collect(),
        control.cancel,
    )?;
    summary.wall = start.elapsed();
    summary.rays = counters.rays();
    summary.samples = counters.samples();
    Ok(summary)
}

/// Returns also the frames that are on disk already.
fn render_all<'a>(
    (plan, rig): (&'a Plan, &CameraRig),
    (scenes, labels): (&mut Scenes<'_>, &mut Labels),
    (survey, coverage): (&Survey, Coverage),
    (observer, control): (&dyn Observer, &Control<'_>),
    send: &SyncSender<Finished<'a>>,
) -> Result<(Summary, Vec<i32>), Error> {
    let (mut summary, mut skipped) = (Summary::default(), Vec::new());
    let (mut renderer, mut unjudged) = (Renderer::new(), JUDGED_FRAMES);
    for (index, frame) in plan.frames.iter().enumerate() {
        if plan.policy.existing == Existing::Skip {
            // Another process may have written it meanwhile.
            let stale = if survey.has(index) {
                None
            } else {
                frame.stale(plan, survey.inputs)
            };
            match stale {
                None => {
                    if plan.policy.checkpoint.is_some() {
                        checkpoint::remove(frame);
                    }
                    // A frame that is there noisy is not yet denoised.
                    if plan.denoises().is_none() {
                        observer.event(&JobEvent::FrameSkipped { frame: frame.number });
                        summary.skipped += 1;
                    }
                    labels.add((plan, rig), scenes, frame, control.cancel)?;
                    skipped.push(frame.number);
                    continue;
                }
                Some(stale) if stale.reason == StaleReason::Missing => {}
                Some(stale) => observer.event(&JobEvent::FrameStale {
                    frame: frame.number,
                    stale: &stale,
                }),
            }
        }
        observer.event(&JobEvent::FrameStarted {
            frame: frame.number,
            index,
            total: plan.frames.len(),
        });
        let start = Instant::now();
        // A frame that cannot be written is not rendered.
        let mut files = frame.files.iter();
        if let Err(error) = files.try_for_each(|file| atomic::check_old(&file.path)) {
            if error.ends_the_job() || plan.policy.on_failure == OnFailure::FailFast {
                return Err(error.into());
            }
            fail(&mut summary, observer, (frame, error.into()));
            continue;
        }
        let eyes = rig.eyes(plan, frame);
        let fingerprint = Fingerprint::of_frame(plan, survey.inputs, frame);
        let interrupts = FrameInterrupts::new(plan, (frame, survey.inputs, &fingerprint.file), coverage, control.show);
        let own_control = Control {
            // They are of one film.
            interrupts: (eyes.len() == 1).then_some(&interrupts as &dyn Interrupts),
            ..*control
        };
        let attempt = failure::catch(|| {
            let films = eyes.iter().map(|camera| {
                let mut of_frame = ScenesOfFrame {
                    scenes: &mut *scenes,
                    number: frame.number,
                    camera,
                };
                plan.render_frame(&renderer, &mut of_frame, (frame, camera), &own_control)
            });
            match films.collect::<Result<Vec<Film>, Failed>>() {
                Ok(films) => interrupts.lost().map_or(Ok(Ok(films)), |error| Err(error.into())),
                Err(Failed::Render(error)) => Ok(Err(error)),
                Err(Failed::Scene(error)) => Err(error),
            }
        });
        let mut films = match attempt.and_then(|found: Result<_, Error>| found.map_err(FrameError::from)) {
            Ok(films) => films?,
            Err(FrameError::Output(error)) if error.ends_the_job() => return Err(error.into()),
            Err(cause) => {
                renderer = Renderer::new();
                scenes.recover();
                fail(&mut summary, observer, (frame, cause));
                match plan.policy.on_failure {
                    OnFailure::KeepGoing => continue,
                    OnFailure::FailFast => break,
                }
            }
        };
        if unjudged > 0
            && let Some(fault) = sight::fault((&films[0], coverage), plan, scenes.current(), &eyes[0])
        {
            unjudged = 0;
            let number = frame.number;
            let text = format!("frame {number}: {fault}");
            plan.warnings.add_live(WarningKind::PICTURE, number, text);
        }
        unjudged = unjudged.saturating_sub(1);
        let first = films.swap_remove(0);
        let film = match plan.picture.second_eye.zip(films.pop()) {
            Some((second, right)) => first.beside(&right, second.layout),
            None => first,
        };
        let took = start.elapsed();
        observer.event(&JobEvent::FrameRendered {
            frame: frame.number,
            took,
        });
        let (got, wanted) = (film.samples, plan.picture.settings.pixel_samples());
        if got < wanted {
            let number = frame.number;
            let text = format!("frame {number} has {got} of {wanted} samples, the time limit is over");
            plan.warnings.add_live(WarningKind::TIME_LIMIT, number, text);
            observer.event(&JobEvent::FrameCutShort {
                frame: frame.number,
                samples: got,
            });
        }
        let invalid = control.counters.map(Counters::take_invalid).unwrap_or_default();
        if invalid.count > 0 {
            summary.invalid.push((frame.number, invalid));
        }
        summary.frame_times.push(took);
        summary.rendered += 1;
        labels.add((plan, rig), scenes, frame, control.cancel)?;
        let finished = Finished {
            frame,
            camera: eyes.into_iter().next().expect("a picture shows an eye"),
            film,
            fingerprint,
        };
        if send.send(finished).is_err() {
            // The writer has given up; its error says why.
            break;
        }
    }
    Ok((summary, skipped))
}

/// Counts a frame that failed, and reports it.
fn fail(summary: &mut Summary, observer: &dyn Observer, (frame, cause): (&PlannedFrame, FrameError)) {
    let failure = FrameFailure {
        frame: frame.number,
        cause,
    };
    observer.event(&JobEvent::FrameFailed(&failure));
    summary.failures.push(failure);
}
