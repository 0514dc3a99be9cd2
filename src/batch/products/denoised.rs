//! The denoised frames of a job: its final files, made of the rendered ones.

use std::{
    cell::RefCell,
    collections::{BTreeMap, BTreeSet, HashSet},
    fs,
    path::PathBuf,
};

use super::{
    denoise::{self, DenoiseRequest, DenoisedFrames, Helpers},
    films,
};
use crate::{
    batch::{
        Existing, FrameFailure, FrameRange, InputHash, JobEvent, Observer, OnFailure, Plan, PlannedFrame, Stale,
        StaleReason, Summary,
        plan::{PlannedFile, denoise_options::DenoisePlan},
        resume::{failure::FrameError, fingerprint::FINGERPRINT},
        writing,
    },
    denoise::DenoiseError,
    error::Error,
    math::{parallel, sorting},
    output::{Coverage, Exr, ExrFile, Format as _, FrameImage, OutputError, Value},
    render::Cancel,
};

/// Denoises the rendered frames of `plan` but for those that failed, and adds what was done to `summary`.
///
/// # Errors
/// Those of [`denoise`](denoise::denoise). A frame that alone cannot be written is a failure in the summary, unless the plan says
/// otherwise.
pub(in crate::batch) fn write(
    (plan, inputs, coverage): (&Plan, InputHash, Coverage),
    summary: &mut Summary,
    observer: &dyn Observer,
    cancel: Option<&Cancel>,
) -> Result<(), Error> {
    let failed: HashSet<i32> = summary.failures.iter().map(|failure| failure.frame).collect();
    let numbers = plan.frames.iter().map(|frame| frame.number);
    let numbers: Vec<i32> = numbers.filter(|number| !failed.contains(number)).collect();
    let is_stopped = !failed.is_empty() && plan.policy.on_failure == OnFailure::FailFast;
    let Some(denoise) = plan.denoises().filter(|_| !numbers.is_empty() && !is_stopped) else {
        return Ok(());
    };
    let frames = JobFrames {
        plan,
        coverage,
        observer,
        files: plan
            .frames
            .iter()
            .map(|frame| (frame.number, plan.final_files(frame)))
            .collect(),
        done: RefCell::default(),
    };
    if !plan.renders() {
        refuse_foreign(plan, inputs)?;
    }
    let beside = helpers(plan, inputs);
    let helpers = numbers.iter().chain(&beside).copied().collect();
    denoise::denoise_into(&request(plan, denoise, &numbers, helpers), &frames, cancel)?;
    let near = |others: &mut dyn Iterator<Item = i32>| -> Vec<i32> {
        let others: Vec<i32> = others.collect();
        let is_near = |number: &i32| others.iter().any(|other| denoise.options.reaches(*number, *other));
        numbers.iter().copied().filter(is_near).collect()
    };
    summary.unhelped = near(&mut failed.iter().copied()).len();
    // Frames beyond the sequence are not missed: no job needs to render them.
    let own = || plan.all_frames().iter().map(|frame| i64::from(frame.number));
    let (first, last) = (own().min(), own().max());
    let is_in_sequence = |number: i64| {
        first.is_none_or(|first| number >= first.min(*plan.extent.start()))
            && last.is_none_or(|last| number <= last.max(*plan.extent.end()))
    };
    let is_missing = |number: &i32| !beside.contains(number) && is_in_sequence(i64::from(*number));
    summary.missing = plan
        .beside
        .iter()
        .map(|frame| frame.number)
        .filter(is_missing)
        .collect();
    summary.unfinished = near(&mut summary.missing.iter().copied());
    summary.outdated = outdated(plan, denoise, &beside);
    let Done {
        written,
        kept,
        failures,
    } = frames.done.into_inner();
    summary.written = written;
    summary.skipped += kept;
    summary.failures.extend(failures);
    sorting::sort_by_key(&mut summary.failures, |failure| failure.frame);
    Ok(())
}

/// Refuses rendered frames that are not those of the plan.
fn refuse_foreign(plan: &Plan, inputs: InputHash) -> Result<(), DenoiseError> {
    let stale = parallel::map(&plan.frames, |frame| frame.stale(plan, inputs));
    let mut stale = stale.into_iter().flatten();
    let foreign = stale.find(|stale| stale.reason == StaleReason::Outdated);
    foreign.map_or(Ok(()), |Stale { path, .. }| Err(DenoiseError::OtherJob { path }))
}

/// The frames of other jobs that are rendered as this one would render them.
fn helpers(plan: &Plan, inputs: InputHash) -> HashSet<i32> {
    let is_there = |frame: &&PlannedFrame| frame.stale(plan, inputs).is_none();
    plan.beside.iter().filter(is_there).map(|frame| frame.number).collect()
}

/// Those of the frames `beside` whose denoised files are older than a rendered frame of this job that helps them.
fn outdated(plan: &Plan, denoise: &DenoisePlan, beside: &HashSet<i32>) -> Vec<i32> {
    let written = |files: &[PlannedFile]| {
        let times = files.iter().map(|file| fs::metadata(&file.path)?.modified());
        times.collect::<Result<Vec<_>, _>>().ok()?.into_iter().min()
    };
    let is_outdated = |other: &&PlannedFrame| {
        let is_newer = |time| {
            let near = |own: &&PlannedFrame| denoise.options.reaches(own.number, other.number);
            let mut own = plan.frames.iter().filter(near);
            own.any(|own| written(&own.files).is_some_and(|rendered| rendered > time))
        };
        beside.contains(&other.number) && written(&plan.final_files(other)).is_some_and(is_newer)
    };
    let outdated = plan.beside.iter().filter(is_outdated);
    outdated.map(|frame| frame.number).collect()
}

/// For each of these frames, whose first stale rendered file is in `noisy`, the first file of it that is not what the job would
/// write, if any.
pub(in crate::batch) fn stale(
    (plan, inputs): (&Plan, InputHash),
    frames: &[PlannedFrame],
    mut noisy: Vec<Option<Stale>>,
) -> Result<Vec<Option<Stale>>, Error> {
    let Some(denoise) = plan.denoises() else {
        return Ok(noisy);
    };
    let pairs = || frames.iter().zip(&noisy);
    let fit: Vec<i32> = pairs()
        .filter(|(_, stale)| stale.is_none())
        .map(|(frame, _)| frame.number)
        .collect();
    let unfit: Vec<i32> = pairs()
        .filter(|(_, stale)| stale.is_some())
        .map(|(frame, _)| frame.number)
        .collect();
    if fit.is_empty() {
        return Ok(noisy);
    }
    let own = plan.frames.iter().map(|frame| frame.number);
    // The frames of other parts help each other.
    let all: BTreeSet<i32> = sorting::ordered(own.chain(helpers(plan, inputs)).chain(fit.iter().copied()));
    let fingerprints = denoise::fingerprints(&request(plan, denoise, &fit, all.into_iter().collect()))?;
    for (frame, stale) in frames.iter().zip(&mut noisy).filter(|(_, stale)| stale.is_none()) {
        let fingerprint = fingerprints.get(&frame.number).cloned().flatten();
        let is_near = |other: &i32| denoise.options.reaches(frame.number, *other);
        let fingerprint = fingerprint.filter(|_| !unfit.iter().any(is_near));
        let files = plan.final_files(frame);
        *stale = files.iter().find_map(|file| file_stale(file, fingerprint.as_deref()));
    }
    Ok(noisy)
}

/// Why a file is not one with this fingerprint, if it is not. Without a fingerprint no file fits.
fn file_stale(file: &PlannedFile, fingerprint: Option<&str>) -> Option<Stale> {
    let reason = if !file.path.exists() {
        StaleReason::Missing
    } else {
        match (file.format.inspect(&file.path), fingerprint) {
            (None, _) => StaleReason::Damaged,
            (_, None) => StaleReason::Unhelped,
            (Some(facts), Some(own)) => match facts.attribute(FINGERPRINT) {
                Some(found) if *found == Value::from(own) => return None,
                Some(_) => StaleReason::Outdated,
                None => StaleReason::Foreign,
            },
        }
    };
    Some(Stale {
        path: file.path.clone(),
        reason,
    })
}

/// The request for these frames, which those in `helpers` may help: other files in the folder may belong to another scene.
fn request(plan: &Plan, denoise: &DenoisePlan, frames: &[i32], helpers: Vec<i32>) -> DenoiseRequest {
    DenoiseRequest {
        input: denoise.noisy.clone(),
        output: denoise.clean[0].clone(),
        frames: Some(FrameRange::of(frames.iter().map(|frame| i64::from(*frame)))),
        helpers: Helpers::Among(helpers),
        options: denoise.options.clone(),
        skip_existing: plan.policy.existing == Existing::Skip,
        simd: plan.picture.accel.simd,
    }
}

/// The denoised frames of a job, which is told of each.
struct JobFrames<'a> {
    plan: &'a Plan,
    coverage: Coverage,
    observer: &'a dyn Observer,
    files: BTreeMap<i32, Vec<PlannedFile>>,
    done: RefCell<Done>,
}

#[derive(Default)]
struct Done {
    written: usize,
    kept: usize,
    failures: Vec<FrameFailure>,
}

impl DenoisedFrames for JobFrames<'_> {
    fn files(&self, frame: i32) -> Vec<PathBuf> {
        self.files[&frame].iter().map(|file| file.path.clone()).collect()
    }

    fn keep(&self, frame: i32, fingerprint: &str) -> bool {
        self.observer
            .event(&JobEvent::DenoisedFingerprint { frame, fingerprint });
        let are_fit = || {
            self.files[&frame]
                .iter()
                .all(|file| file_stale(file, Some(fingerprint)).is_none())
        };
        let is_kept = self.plan.policy.existing == Existing::Skip && are_fit();
        if is_kept {
            self.done.borrow_mut().kept += 1;
            self.observer.event(&JobEvent::FrameSkipped { frame });
        }
        is_kept
    }

    fn write(&self, frame: i32, file: &ExrFile) -> Result<(), Error> {
        let failure = match self.write_files(frame, file) {
            Ok(()) => {
                self.done.borrow_mut().written += 1;
                self.observer.event(&JobEvent::FrameWritten { frame });
                return Ok(());
            }
            Err(error) if error.ends_the_job() || self.plan.policy.on_failure == OnFailure::FailFast => {
                return Err(error.into());
            }
            Err(error) => FrameFailure {
                frame,
                cause: FrameError::Output(error),
            },
        };
        self.observer.event(&JobEvent::FrameFailed(&failure));
        self.done.borrow_mut().failures.push(failure);
        Ok(())
    }
}

impl JobFrames<'_> {
    fn write_files(&self, frame: i32, file: &ExrFile) -> Result<(), OutputError> {
        let film = match self.plan.files.has_arrays {
            true => films::all_passes(file, self.plan).map_err(|unknown| OutputError::Encode {
                reason: unknown.to_string(),
                path: self.files[&frame][0].path.clone(),
            })?,
            false => films::picture(file),
        };
        let mut metadata = self.plan.metadata(frame);
        metadata.samples = film.samples;
        metadata.attributes = file.given_attributes().cloned().collect();
        let image = FrameImage {
            film: &film,
            shown: self.plan.picture.shown,
            coverage: self.coverage,
            metadata: &metadata,
        };
        self.observer.event(&JobEvent::FrameImage { frame, image: &image });
        for PlannedFile { path, format } in &self.files[&frame] {
            if format.name() == Exr.name() {
                writing::attempts(self.plan, || denoise::write(path, file))?;
            } else {
                writing::write(self.plan, path, *format, &image)?;
            }
            self.observer.event(&JobEvent::FrameDenoised { frame, file: path });
        }
        Ok(())
    }
}
