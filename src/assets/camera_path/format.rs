//! The contract of formats of camera paths.

use super::{
    PathProblems, Source,
    held::{Holds, Target, Written},
    still::Still,
};
use crate::camera::path::CameraPath;

/// A format of camera paths.
#[derive(Debug)]
pub struct CameraPathFormat {
    pub name: &'static str,
    /// File extensions, in lower case.
    pub extensions: &'static [&'static str],
    /// The names of the only files of this format, if other formats have their endings.
    pub(super) names: &'static [&'static str],
    pub(super) read: fn(&Source<'_>) -> Result<CameraPath, PathProblems>,
    pub(super) holds: Holds,
    /// Makes the files of cameras, of which there is at least one.
    pub(super) write: fn(&Target<'_>, &[Still]) -> Written,
}

impl CameraPathFormat {
    /// Whether a file may have columns of values beside those of the camera.
    pub fn holds_values(&self) -> bool {
        self.name == "csv"
    }

    /// Reads a camera path in this format.
    ///
    /// # Errors
    /// Up to 20 problems, and how many more there are.
    pub fn read(&self, source: &Source<'_>) -> Result<CameraPath, PathProblems> {
        (self.read)(source)
    }
}
