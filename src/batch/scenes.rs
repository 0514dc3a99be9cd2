//! The scenes of a job's frames.

use crate::{error::Error, scene::Scene};

/// The source of the scenes that a job renders. [`Scenes::seek`] gives the scene of a frame, which depends on the frame alone and
/// never on those that were sought before.
pub struct Scenes {
    scene: Scene,
}

impl Scenes {
    /// The same scene for all frames.
    pub fn still(scene: Scene) -> Self {
        Self { scene }
    }

    /// Whether all frames have the same scene.
    pub fn is_still(&self) -> bool {
        true
    }

    /// The scene at a time in frames, which may lie between two of them.
    ///
    /// # Errors
    /// There is no such scene: a value of this time does not fit the others, or a file that it names cannot be loaded.
    pub fn seek(&mut self, _frame: f64) -> Result<&Scene, Error> {
        Ok(&self.scene)
    }

    /// The scene that was sought last. Its names and ids are those of all frames.
    pub fn current(&self) -> &Scene {
        &self.scene
    }

    /// Drops what a panic may have left inconsistent.
    pub(super) fn recover(&mut self) {}
}
