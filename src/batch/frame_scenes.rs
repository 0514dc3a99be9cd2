//! The scenes of a frame of a job, at the times of its shutter and of its neighbours.

use super::Scenes;
use crate::{
    camera::FrameCamera,
    describe::FrameTime,
    error::Error,
    render::{FrameScenes, RenderError, SceneTime},
    scene::Scene,
};

/// The scenes of a job at the times of a frame.
pub(super) struct ScenesOfFrame<'a, 'j> {
    pub scenes: &'a mut Scenes<'j>,
    pub number: i32,
    pub camera: &'a FrameCamera,
}

/// Why a frame was not rendered.
pub(super) enum Failed {
    Render(RenderError),
    Scene(Error),
}

impl From<RenderError> for Failed {
    fn from(error: RenderError) -> Self {
        Self::Render(error)
    }
}

/// A time of a frame, in frames.
pub fn time_in_frames(number: i32, camera: &FrameCamera, time: SceneTime) -> FrameTime {
    let [before, after] = camera.openings_around();
    let (from_own, away) = match time {
        SceneTime::Shutter(u) => (camera.shutter_time(u), 0),
        SceneTime::Before => (before, -1),
        SceneTime::After => (after, 1),
    };
    FrameTime {
        time: f64::from(number) + from_own,
        frame: i64::from(number) + away,
    }
}

impl FrameScenes for ScenesOfFrame<'_, '_> {
    type Error = Failed;

    fn is_still(&self, times: impl Iterator<Item = SceneTime>) -> bool {
        let in_frames = |time| time_in_frames(self.number, self.camera, time);
        self.scenes.is_same(times.map(in_frames))
    }

    fn at(&mut self, time: SceneTime) -> Result<&Scene, Failed> {
        let time = time_in_frames(self.number, self.camera, time);
        self.scenes.seek(time).map_err(Failed::Scene)
    }
}
