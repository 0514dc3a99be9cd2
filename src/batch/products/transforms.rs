//! The content of `transforms.json`: the cameras of a sequence.

use std::{collections::HashSet, fs, io, path::Path};

use serde::de::DeserializeOwned;

use super::{
    draws::draws,
    metadata::{calibrated, camera_model, common_model},
};
use crate::{
    assets::camera_path::{
        keys::Intrinsics,
        still::Still,
        transforms::{CONVENTIONS, Frame, Transforms},
    },
    batch::{
        CameraRig, Fingerprint, InputHash, Plan, PlannedFrame,
        resume::fingerprint::{FINGERPRINT, SCENE},
    },
    camera::CalibratedView,
    error::Error,
    film::Window,
    math::sorting,
    output::{Value, atomic},
    warnings::WarningKind,
};

/// The name of the picture of a frame.
pub(super) fn picture_name(plan: &Plan, frame: i32) -> String {
    let path = plan.files.picture.as_ref().map(|pattern| pattern.path(frame));
    let name = path.as_deref().and_then(Path::file_name).unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// Whether the picture of a frame of another part is there as this job would make it, by its header: that part may never render
/// it, and an earlier job may have left another.
fn is_of_job(plan: &Plan, inputs: InputHash, frame: &PlannedFrame) -> bool {
    let picture = plan.files.picture.as_ref();
    let facts = picture.and_then(|picture| picture.format().facts(&picture.path(frame.number)));
    let (settings, own) = (&plan.picture.settings, Fingerprint::of_frame(plan, inputs, frame));
    let (name, own) = match plan.files.denoise {
        // The fingerprint of a denoised picture depends on the frames around it.
        Some(_) => (SCENE, own.scene),
        None => (FINGERPRINT, own.file),
    };
    facts.is_some_and(|facts| {
        let is_same_size = (facts.resolution, facts.window) == (settings.resolution, settings.window);
        is_same_size && facts.attribute(name) == Some(&Value::from(own))
    })
}

/// The file of a job, of whose own frames those in `done` are on disk.
pub(super) fn of_job(
    (plan, inputs): (&Plan, InputHash),
    rig: &CameraRig,
    done: &HashSet<i32>,
) -> Result<Transforms, Error> {
    let window = plan.picture.settings.window;
    let frame = |frame: &PlannedFrame| {
        let still = still(
            (frame.number, picture_name(plan, frame.number)),
            &calibrated(&rig.camera(plan, frame))?,
            window,
        );
        let own = Frame::new(&still).map_err(Error::Usage)?;
        Ok::<_, Error>(Frame {
            values: draws(plan.values.as_deref(), frame.number),
            ..own
        })
    };
    let model = camera_model(plan.all_frames().iter().map(|frame| &frame.camera))?;
    let own: HashSet<i32> = plan.frames.iter().map(|frame| frame.number).collect();
    let is_listed = |frame: &&PlannedFrame| match own.contains(&frame.number) {
        true => done.contains(&frame.number),
        false => is_of_job(plan, inputs, frame),
    };
    let frames = plan.all_frames().iter().filter(is_listed).map(frame);
    Ok(Transforms {
        conventions: CONVENTIONS.into(),
        camera_model: model.into(),
        model_place: plan
            .model_place
            .map(|place| serde_json::to_value(place).expect("numbers are JSON")),
        w: window.width(),
        h: window.height(),
        frames: frames.collect::<Result<_, Error>>()?,
    })
}

/// What other parts of the job have written into the file at `path`; `None` where there is none.
///
/// # Errors
/// The file is damaged; the text says how.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, String> {
    match fs::read(path) {
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(cause) => Err(cause.to_string()),
        Ok(text) => serde_json::from_slice(&text)
            .map(Some)
            .map_err(|cause| cause.to_string()),
    }
}

/// Adds the frames of other parts of the same sequence, in rising order, if the job is a part of it. Frames of this job replace
/// theirs. Warns of pictures of other jobs that are there and that the file lists no more.
pub(super) fn join(own: &mut Transforms, others: Transforms, plan: &Plan, path: &Path) {
    let model = common_model(&own.camera_model, &others.camera_model).map(str::to_owned);
    if plan.is_chunk
        && let Some(why) = difference(own, &others, model.is_some())
    {
        let path = path.display();
        let frames = match others.frames.len() {
            1 => "1 frame of other jobs is".to_owned(),
            count => format!("{count} frames of other jobs are"),
        };
        let text = format!("{frames} lost: {why}: {path}");
        plan.warnings.add_live(WarningKind::LOST_FRAMES, path, text);
        return;
    }
    if let Some(model) = model.filter(|_| plan.is_chunk) {
        own.camera_model = model.into();
    }
    let numbers: HashSet<i32> = own.frames.iter().map(|frame| frame.frame).collect();
    let names: HashSet<String> = own.frames.iter().map(|frame| frame.file_path.clone()).collect();
    let is_of_sequence = |frame: &Frame| picture_name(plan, frame.frame) == frame.file_path;
    let (kept, lost): (Vec<Frame>, Vec<Frame>) = others
        .frames
        .into_iter()
        .filter(|frame| !names.contains(&frame.file_path))
        .partition(|frame| plan.is_chunk && !numbers.contains(&frame.frame) && is_of_sequence(frame));
    own.frames.extend(kept);
    sorting::sort_by_key(&mut own.frames, |frame| frame.frame);
    warn_of_lost(&lost, plan, path);
}

/// Why frames of two files cannot be in one.
fn difference(own: &Transforms, others: &Transforms, have_common_model: bool) -> Option<String> {
    if (own.w, own.h) != (others.w, others.h) {
        return Some(format!(
            "their pictures have {}x{} pixels, those of this job {}x{}",
            others.w, others.h, own.w, own.h
        ));
    }
    if !have_common_model {
        return Some(format!(
            "their camera model is {}, that of this job {}",
            others.camera_model, own.camera_model
        ));
    }
    if own.model_place != others.model_place {
        return Some("the model has another place or size in their pictures".to_owned());
    }
    (own.conventions != others.conventions).then(|| "another version of the program wrote them".to_owned())
}

/// Warns of those of these frames whose pictures are there.
fn warn_of_lost(lost: &[Frame], plan: &Plan, path: &Path) {
    let folder = atomic::folder_of(path);
    let mut names = lost.iter().map(|frame| frame.file_path.as_str());
    let mut shown = names.by_ref().filter(|name| folder.join(name).exists());
    let Some(first) = shown.next() else { return };
    let more = match shown.count() {
        0 => String::new(),
        count => format!(" and {count} more"),
    };
    let path = path.display();
    let text = format!("{path} no longer lists {first}{more}, of another job: give each sequence a folder of its own");
    plan.warnings.add_live(WarningKind::LOST_FRAMES, path, text);
}

/// The frame of this number and picture, which shows `window` of the whole.
fn still((frame, name): (i32, String), calibrated: &CalibratedView, window: Window) -> Still {
    let view = &calibrated.view;
    let [cx, cy] = view.center;
    Still {
        frame: frame.into(),
        name: Some(name),
        eye: view.eye,
        axes: view.axes,
        fov: None,
        pixels: Some(Intrinsics {
            focal: view.focal,
            center: [Some(cx - f64::from(window.x0)), Some(cy - f64::from(window.y0))],
            skew: 0.0,
            size: Some([window.width(), window.height()].map(f64::from)),
            distortion: calibrated.distortion,
        }),
        is_calibrated: true,
        has_blur: false,
    }
}
