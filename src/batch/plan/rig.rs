//! The cameras of a job's frames.

use crate::batch::{Plan, PlannedFrame};

use super::turntable::Orbit;
use crate::{
    camera::{FrameCamera, StereoEye},
    scene::Scene,
};

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

    /// The camera of a frame of the plan; of a picture of both eyes, that of the left one.
    pub fn camera(&self, plan: &Plan, frame: &PlannedFrame) -> FrameCamera {
        self.of_eye(plan, (frame.number, &frame.camera), plan.picture.stereo.as_ref())
    }

    /// The cameras of the eyes that a picture shows.
    pub(in crate::batch) fn eyes(&self, plan: &Plan, frame: &PlannedFrame) -> Vec<FrameCamera> {
        let second = plan.picture.second_eye.map(|second| second.eye);
        let second = frame
            .second
            .iter()
            .map(|camera| self.of_eye(plan, (frame.number, camera), second.as_ref()));
        [self.camera(plan, frame)].into_iter().chain(second).collect()
    }

    /// The camera of an eye, of which the plan has made `planned`.
    fn of_eye(&self, plan: &Plan, (number, planned): (i32, &FrameCamera), eye: Option<&StereoEye>) -> FrameCamera {
        match &self.orbit {
            None => planned.clone(),
            Some(orbit) => {
                let camera = orbit.camera(number, plan.picture.settings.resolution);
                // The plan has made the eye of the start of the orbit.
                let eye = eye.and_then(|eye| camera.of_eye(eye).ok());
                let camera = eye.unwrap_or(camera);
                FrameCamera::from(camera).with_timing(planned.timing())
            }
        }
    }
}
