//! The labels of the pictures of a job: the instances of `coco.json`, and the names of `ids.json`
//! where frames have names of their own.

use super::{
    coco::Instances,
    ids::{Names, NamesOfFrames},
    metadata::Sidecar,
};
use crate::{
    batch::{
        CameraRig, Plan, PlannedFrame, Scenes,
        frame_scenes::{Failed, ScenesOfFrame, time_in_frames},
    },
    error::Error,
    render::{Cancel, SceneTime},
};

/// Whether `ids.json` has tables for frames.
pub(super) fn has_names_of_frames(plan: &Plan) -> bool {
    let change = plan.values.as_deref().is_some_and(|values| values.changes_models());
    plan.files.sidecars.contains(&Sidecar::Ids) && change
}

/// The labels of the frames so far.
pub(in crate::batch) struct Labels {
    pub(super) instances: Option<Instances>,
    pub(super) names: Option<NamesOfFrames>,
}

impl Labels {
    /// Those of no frame yet, as far as the plan has files for them.
    pub fn new(plan: &Plan) -> Self {
        let has_instances = plan.files.sidecars.contains(&Sidecar::Coco);
        Self {
            instances: has_instances.then(|| Instances::new(plan)),
            names: has_names_of_frames(plan).then(NamesOfFrames::default),
        }
    }

    /// Adds those of a frame, which do not depend on whether it was rendered now or before.
    ///
    /// # Errors
    /// The job was cancelled, or the frame has no scene.
    pub fn add(
        &mut self,
        (plan, rig): (&Plan, &CameraRig),
        scenes: &mut Scenes<'_>,
        frame: &PlannedFrame,
        cancel: Option<&Cancel>,
    ) -> Result<(), Error> {
        if self.instances.is_none() && self.names.is_none() {
            return Ok(());
        }
        let camera = rig.camera(plan, frame);
        let film = self.instances.as_ref().map(|_| {
            let mut of_frame = ScenesOfFrame {
                scenes: &mut *scenes,
                number: frame.number,
                camera: &camera,
            };
            plan.render_objects(&mut of_frame, (frame, &camera), cancel)
        });
        let film = film.transpose().map_err(|failed| match failed {
            Failed::Render(error) => error.into(),
            Failed::Scene(error) => error,
        })?;
        // The scene that was rendered last may be that of another time.
        let scene = scenes.seek(time_in_frames(frame.number, &camera, SceneTime::OPENING))?;
        if let (Some(instances), Some(film)) = (&mut self.instances, &film) {
            instances.add(plan, frame.number, (film, scene));
        }
        if let Some(names) = &mut self.names {
            names.add(frame.number, Names::new(scene));
        }
        Ok(())
    }
}
