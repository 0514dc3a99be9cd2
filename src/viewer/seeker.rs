//! The scene of a viewer at the frame of the timeline.

use super::{base::Base, shown::Shown};
use crate::{
    batch::{Scenes, time_in_frames},
    camera::FrameCamera,
    describe::FrameTime,
    error::Error,
    render::{FrameScenes, SceneTime},
    scene::Scene,
};

/// The scenes of the frames of a base. It changes what the base shows.
pub struct Seeker<'b> {
    scenes: Scenes<'b>,
    shown: &'b Shown,
    /// The time of the scene, once it was sought.
    at: Option<FrameTime>,
}

impl<'b> Seeker<'b> {
    /// The only seeker of a base.
    pub fn new(base: &'b Base) -> Self {
        let scene = base.shown.take().expect("a base has one seeker");
        let scenes = base.job.scenes(scene);
        base.shown.set(scenes.shared());
        Self {
            scenes,
            shown: &base.shown,
            at: None,
        }
    }

    /// Whether all frames have the same scene.
    pub fn is_still(&self) -> bool {
        self.scenes.is_still()
    }

    /// Returns the scene at a time, and shows it.
    ///
    /// # Errors
    /// There is no such scene.
    pub fn seek(&mut self, time: impl Into<FrameTime>) -> Result<&Scene, Error> {
        let time = time.into();
        if !self.is_still() && self.at != Some(time) {
            self.at = None;
            // Only a scene that nobody else has is changed in place.
            drop(self.shown.take());
            self.scenes.seek(time)?;
            self.at = Some(time);
            self.shown.set(self.scenes.shared());
        }
        Ok(self.scenes.current())
    }
}

/// The scenes at the times of a frame.
pub struct SeekerOfFrame<'a, 'b> {
    pub seeker: &'a mut Seeker<'b>,
    pub number: i32,
    pub camera: &'a FrameCamera,
}

impl FrameScenes for SeekerOfFrame<'_, '_> {
    type Error = Error;

    fn is_still(&self, times: impl Iterator<Item = SceneTime>) -> bool {
        let in_frames = |time| time_in_frames(self.number, self.camera, time);
        self.seeker.scenes.is_same(times.map(in_frames))
    }

    fn at(&mut self, time: SceneTime) -> Result<&Scene, Error> {
        self.seeker.seek(time_in_frames(self.number, self.camera, time))
    }
}
