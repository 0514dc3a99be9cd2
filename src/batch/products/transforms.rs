//! The content of `transforms.json`: the cameras of a sequence.

use std::{borrow::Cow, collections::HashSet, fs, path::Path};

use glam::DMat3;
use serde::{Deserialize, Serialize};

use super::metadata::calibrated;
use crate::{
    batch::{
        CameraRig, Fingerprint, FrameFailure, InputHash, Plan, PlannedFrame,
        resume::fingerprint::{FINGERPRINT, SCENE},
    },
    camera::{CalibratedView, ViewDistortion},
    compile::default_scene::normalise::ModelPlace,
    error::Error,
    film::Window,
    output::Value,
    warnings::{WarningKind, Warnings},
};

/// The name of the picture of a frame.
fn picture_name(plan: &Plan, frame: i32) -> String {
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

/// The content of `transforms.json`.
#[derive(Serialize, Deserialize)]
pub(super) struct Transforms {
    conventions: Cow<'static, str>,
    pub camera_model: Cow<'static, str>,
    /// The place of a model by itself that was moved to have a common size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    model_place: Option<ModelPlace>,
    pub w: u32,
    pub h: u32,
    pub frames: Vec<Frame>,
}

/// The camera of a frame, camera to world; it looks along its -z with +y up.
#[derive(Serialize, Deserialize)]
pub(super) struct Frame {
    pub file_path: String,
    pub frame: i32,
    pub fl_x: f64,
    pub fl_y: f64,
    pub cx: f64,
    pub cy: f64,
    camera_angle_x: f64,
    camera_angle_y: f64,
    #[serde(flatten)]
    pub distortion: Coefficients,
    pub transform_matrix: [[f64; 4]; 4],
}

/// Coefficients under their names.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Coefficients {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k1: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k2: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k3: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k4: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p1: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p2: Option<f64>,
}

impl From<ViewDistortion> for Coefficients {
    fn from(distortion: ViewDistortion) -> Self {
        let radial = |k1, k2, k3| Self {
            k1: Some(k1),
            k2: Some(k2),
            k3: Some(k3),
            ..Self::default()
        };
        match distortion {
            ViewDistortion::None => Self::default(),
            // Cameras with the other terms are refused.
            ViewDistortion::OpenCv([k1, k2, p1, p2, k3, ..]) => Self {
                p1: Some(p1),
                p2: Some(p2),
                ..radial(k1, k2, k3)
            },
            ViewDistortion::OpenCvFisheye([k1, k2, k3, k4]) => Self {
                k4: Some(k4),
                ..radial(k1, k2, k3)
            },
        }
    }
}

impl Transforms {
    pub fn new((plan, inputs): (&Plan, InputHash), rig: &CameraRig, failures: &[FrameFailure]) -> Result<Self, Error> {
        let window = plan.picture.settings.window;
        let frame = |frame: &PlannedFrame| {
            Ok(Frame::new(
                (frame.number, picture_name(plan, frame.number)),
                &calibrated(&rig.camera(plan, frame))?,
                window,
            ))
        };
        let first = plan.all_frames().first();
        let first = first.map(|frame| calibrated(&rig.camera(plan, frame))).transpose()?;
        let model = match first.map(|view| view.distortion).unwrap_or_default() {
            ViewDistortion::None => "PINHOLE",
            ViewDistortion::OpenCv(_) => "OPENCV",
            ViewDistortion::OpenCvFisheye(_) => "OPENCV_FISHEYE",
        };
        let own: HashSet<i32> = plan.frames.iter().map(|frame| frame.number).collect();
        let failed: HashSet<i32> = failures.iter().map(|failure| failure.frame).collect();
        let is_listed = |frame: &&PlannedFrame| match own.contains(&frame.number) {
            true => !failed.contains(&frame.number),
            false => is_of_job(plan, inputs, frame),
        };
        let frames = plan.all_frames().iter().filter(is_listed).map(frame);
        Ok(Self {
            conventions: "transform_matrix is camera to world, in metres; the camera looks along its -z, +y is up; \
                          lengths of intrinsics are in pixels, and pixel centres are at .5; cameras are those at which shutters open"
                .into(),
            camera_model: model.into(),
            model_place: plan.model_place,
            w: window.width(),
            h: window.height(),
            frames: frames.collect::<Result<_, Error>>()?,
        })
    }

    /// The content of the file at `path`; `None` where there is none, or it is damaged.
    pub fn read(path: &Path, warnings: &Warnings) -> Option<Self> {
        let text = path.is_file().then(|| fs::read(path).ok()).flatten()?;
        let read = serde_json::from_slice(&text);
        let lost = |cause| format!("the frames of other jobs are lost, {cause}: {}", path.display());
        read.map_err(|cause| warnings.add_live(WarningKind::LOST_FRAMES, path.display(), lost(cause)))
            .ok()
    }

    /// Adds the frames of other jobs of the same sequence, in rising order. Frames of this job replace theirs.
    pub fn join(&mut self, others: Self, plan: &Plan, path: &Path) {
        let head = |t: &Self| (t.conventions.clone(), t.camera_model.clone(), t.model_place, t.w, t.h);
        if head(self) != head(&others) {
            let (frames, path) = (others.frames.len(), path.display());
            let text = format!(
                "the {frames} frames of other jobs are lost: their pictures have {}x{} pixels, those of this job {}x{}: {path}",
                others.w, others.h, self.w, self.h
            );
            plan.warnings.add_live(WarningKind::LOST_FRAMES, path, text);
            return;
        }
        let numbers: HashSet<i32> = self.frames.iter().map(|frame| frame.frame).collect();
        let names: HashSet<String> = self.frames.iter().map(|frame| frame.file_path.clone()).collect();
        let is_of_sequence = |frame: &Frame| picture_name(plan, frame.frame) == frame.file_path;
        let others = others.frames.into_iter();
        self.frames.extend(others.filter(|frame| {
            !numbers.contains(&frame.frame) && !names.contains(&frame.file_path) && is_of_sequence(frame)
        }));
        self.frames.sort_by_key(|frame| frame.frame);
    }
}

impl Frame {
    /// The frame of this number and picture, which shows `window` of the whole.
    fn new((frame, file_path): (i32, String), calibrated: &CalibratedView, window: Window) -> Self {
        let view = &calibrated.view;
        let angle = |size: u32, focal: f64| 2.0 * libm::atan(0.5 * f64::from(size) / focal);
        let (DMat3 { x_axis, y_axis, z_axis }, eye) = (view.axes, view.eye);
        let row = |i: usize| [x_axis[i], y_axis[i], z_axis[i], eye[i]];
        let ([fl_x, fl_y], [cx, cy]) = (view.focal, view.center);
        Self {
            file_path,
            frame,
            fl_x,
            fl_y,
            cx: cx - f64::from(window.x0),
            cy: cy - f64::from(window.y0),
            camera_angle_x: angle(window.width(), fl_x),
            camera_angle_y: angle(window.height(), fl_y),
            distortion: calibrated.distortion.into(),
            transform_matrix: [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
        }
    }
}
