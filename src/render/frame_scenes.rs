//! The scenes of a frame: one that moves while the shutter is open, or one that does not.

use super::{RenderError, SceneTime};
use crate::{
    camera::Neighbours,
    scene::{Scene, SceneMotion, ScenePlaces},
};

/// The scenes of a frame, which are sought at its times.
pub trait FrameScenes {
    type Error: From<RenderError>;

    /// Whether the scene is the same at all of these times.
    fn is_still(&self, times: impl Iterator<Item = SceneTime>) -> bool;

    /// Returns the scene at a time. Its origin, its ids and its light groups are the same at all times.
    ///
    /// # Errors
    /// There is no such scene.
    fn at(&mut self, time: SceneTime) -> Result<&Scene, Self::Error>;
}

/// A scene that does not move.
pub struct StillScene<'a>(pub &'a Scene);

impl FrameScenes for StillScene<'_> {
    type Error = RenderError;

    fn is_still(&self, _: impl Iterator<Item = SceneTime>) -> bool {
        true
    }

    fn at(&mut self, _: SceneTime) -> Result<&Scene, RenderError> {
        Ok(self.0)
    }
}

/// The motion of a scene between a frame and those of its neighbours that have a camera; `None` if it does not move.
pub(super) fn motion<S: FrameScenes>(
    scenes: &mut S,
    neighbours: &Neighbours,
    moves_within: bool,
) -> Result<Option<SceneMotion>, S::Error> {
    let times = [SceneTime::Before, SceneTime::OPENING, SceneTime::After];
    if !moves_within && scenes.is_still(times.into_iter()) {
        return Ok(None);
    }
    let mut at = |time| scenes.at(time).map(ScenePlaces::new);
    let before = neighbours
        .previous
        .as_ref()
        .map(|_| at(SceneTime::Before))
        .transpose()?;
    let now = at(SceneTime::OPENING)?;
    let after = neighbours.next.as_ref().map(|_| at(SceneTime::After)).transpose()?;
    Ok(Some(SceneMotion::new(before, now, after)))
}
