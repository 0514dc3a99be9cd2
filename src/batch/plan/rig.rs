//! The cameras of a job's frames.

use crate::batch::{Plan, PlannedFrame};

use super::turntable::Orbit;
use crate::{camera::FrameCamera, scene::Scene};

/// The source of a job's cameras: the camera path, or an orbit around the scene.
#[derive(Clone, Copy, Debug)]
pub struct CameraRig {
    orbit: Option<Orbit>,
}

impl CameraRig {
    /// The rig of `plan` in `scene`.
    pub fn new(plan: &Plan, scene: &Scene) -> Self {
        Self {
            orbit: plan.picture.turntable.map(|turntable| turntable.around(scene)),
        }
    }

    /// The camera of a frame of the plan.
    pub fn camera(&self, plan: &Plan, frame: &PlannedFrame) -> FrameCamera {
        match &self.orbit {
            None => frame.camera.clone(),
            Some(orbit) => {
                let camera = orbit.camera(frame.number, plan.picture.settings.resolution);
                // The plan has made the eye of the start of the orbit.
                let eye = plan.picture.stereo.and_then(|eye| camera.of_eye(&eye).ok());
                let camera = eye.unwrap_or(camera);
                FrameCamera::from(camera).with_timing(frame.camera.timing())
            }
        }
    }
}
