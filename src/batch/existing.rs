//! Files that are there before a job starts.

use super::PlannedFrame;

/// What happens to frames whose files exist.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// They are rendered again.
    #[default]
    Overwrite,
    /// They are left out if all their files are whole.
    Skip,
    /// The job does not start.
    Fail,
}

impl PlannedFrame {
    /// Whether every file of the frame exists with nothing missing.
    pub(super) fn is_on_disk(&self) -> bool {
        self.files.iter().all(|f| f.format.inspect(&f.path).is_some())
    }
}
