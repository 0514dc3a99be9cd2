//! Scenes that move while the shutter is open, and from frame to frame.

use super::RenderError;
use crate::{
    camera::Neighbours,
    scene::{Scene, SceneMotion, ScenePlaces},
};

/// A time of a frame at which its scene is sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SceneTime {
    /// A fraction, from 0 to 1, of the time while the shutter is open.
    Shutter(f64),
    /// As the shutter of the frame before opens.
    Before,
    /// As the shutter of the next frame opens.
    After,
}

impl SceneTime {
    /// As the shutter opens.
    pub const OPENING: Self = Self::Shutter(0.0);
}

/// The scene of a frame, which can be sought at any time of it.
pub trait MovingScene {
    type Error: From<RenderError>;

    /// Whether the scene is the same at all times of the frame, so that it is rendered as one that does not move.
    fn is_still(&self) -> bool;

    /// Returns the scene at a time. Its origin, its ids and its light groups are the same at all times.
    ///
    /// # Errors
    /// There is no such scene.
    fn at(&mut self, time: SceneTime) -> Result<&Scene, Self::Error>;
}

/// A scene that does not move.
pub(super) struct StillScene<'a>(pub &'a Scene);

impl MovingScene for StillScene<'_> {
    type Error = RenderError;

    fn is_still(&self) -> bool {
        true
    }

    fn at(&mut self, _: SceneTime) -> Result<&Scene, RenderError> {
        Ok(self.0)
    }
}

/// The motion of a scene between a frame and those of its neighbours that have a camera.
pub(super) fn motion<S: MovingScene>(scenes: &mut S, neighbours: &Neighbours) -> Result<SceneMotion, S::Error> {
    let mut at = |time| scenes.at(time).map(ScenePlaces::new);
    let before = neighbours.previous.map(|_| at(SceneTime::Before)).transpose()?;
    let now = at(SceneTime::OPENING)?;
    let after = neighbours.next.map(|_| at(SceneTime::After)).transpose()?;
    Ok(SceneMotion::new(before, now, after))
}
