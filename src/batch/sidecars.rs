//! The contents of the files beside the pictures of a job.

use std::path::Path;

use glam::DMat3;
use serde::Serialize;

use super::{
    CameraRig, Plan, PlannedFrame,
    metadata::{Sidecar, pinhole},
};
use crate::{camera::perspective::PinholeView, error::Error, film::Window, output::atomic, scene::Scene};

/// Writes the files beside the pictures of a plan.
pub(super) fn write(plan: &Plan, scene: &Scene) -> Result<(), Error> {
    for sidecar in &plan.files.sidecars {
        let Some(path) = plan.sidecar_path(*sidecar) else {
            continue;
        };
        let content = content(*sidecar, plan, scene)?;
        atomic::write(&path, |out| Ok(out.write_all(content.as_bytes())?))?;
    }
    Ok(())
}

fn content(sidecar: Sidecar, plan: &Plan, scene: &Scene) -> Result<String, Error> {
    let json = match sidecar {
        Sidecar::Transforms => serde_json::to_string_pretty(&Transforms::new(plan, scene)?),
        Sidecar::Ids => serde_json::to_string_pretty(&Ids::new(scene)),
    };
    Ok(json.expect("numbers and texts are JSON") + "\n")
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The content of `transforms.json`.
#[derive(Serialize)]
struct Transforms {
    conventions: &'static str,
    camera_model: &'static str,
    w: u32,
    h: u32,
    frames: Vec<Frame>,
}

#[derive(Serialize)]
struct Frame {
    file_path: String,
    frame: i32,
    fl_x: f64,
    fl_y: f64,
    cx: f64,
    cy: f64,
    camera_angle_x: f64,
    camera_angle_y: f64,
    transform_matrix: [[f64; 4]; 4],
}

impl Transforms {
    fn new(plan: &Plan, scene: &Scene) -> Result<Self, Error> {
        let rig = CameraRig::new(plan, scene);
        let window = plan.picture.settings.window;
        let frame = |frame| Ok(Frame::new(frame, &pinhole(&rig.camera(plan, frame))?, window));
        let frames = plan.all_frames().iter().map(frame);
        Ok(Self {
            conventions: "transform_matrix is camera to world, in metres; the camera looks along its -z, +y is up; \
                          lengths of intrinsics are in pixels, and pixel centres are at .5; cameras are those at which shutters open",
            camera_model: "PINHOLE",
            w: window.width(),
            h: window.height(),
            frames: frames.collect::<Result<_, Error>>()?,
        })
    }
}

impl Frame {
    /// The frame of a picture that shows `window` of the whole.
    fn new(frame: &PlannedFrame, view: &PinholeView, window: Window) -> Self {
        let angle = |size: u32, focal: f64| 2.0 * libm::atan(0.5 * f64::from(size) / focal);
        let (DMat3 { x_axis, y_axis, z_axis }, eye) = (view.axes, view.eye);
        let row = |i: usize| [x_axis[i], y_axis[i], z_axis[i], eye[i]];
        let ([fl_x, fl_y], [cx, cy]) = (view.focal, view.center);
        Self {
            file_path: frame.picture().map(file_name).unwrap_or_default(),
            frame: frame.number,
            fl_x,
            fl_y,
            cx: cx - f64::from(window.x0),
            cy: cy - f64::from(window.y0),
            camera_angle_x: angle(window.width(), fl_x),
            camera_angle_y: angle(window.height(), fl_y),
            transform_matrix: [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
        }
    }
}

/// The content of `ids.json`: names in the order of their numbers, of which the first is 1.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Ids<'a> {
    conventions: &'static str,
    object_id: Vec<&'a str>,
    material_id: Vec<&'a str>,
}

impl<'a> Ids<'a> {
    fn new(scene: &'a Scene) -> Self {
        Self {
            conventions: "the first name has the number 1; 0 is nothing",
            object_id: scene
                .geometry
                .objects
                .iter()
                .map(|object| object.name.as_str())
                .collect(),
            material_id: scene.shading.material_names.iter().map(String::as_str).collect(),
        }
    }
}
