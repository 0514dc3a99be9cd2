//! The treatment of existing files.

/// The treatment of frames whose files exist.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// They are rendered again and replaced.
    #[default]
    Overwrite,
    /// They are skipped if all their files are complete and are what the job would write.
    Skip,
    /// The job does not start.
    Fail,
}
