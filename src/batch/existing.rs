//! Files that are there before a job starts.

/// The treatment of frames whose files exist.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// They are rendered again.
    #[default]
    Overwrite,
    /// They are left out if all their files are whole and are those that the job would write.
    Skip,
    /// The job does not start.
    Fail,
}
