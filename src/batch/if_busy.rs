//! Files that another job is writing.

/// The behaviour of a job whose files another one is writing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IfBusy {
    /// It waits until the other one has ended.
    #[default]
    Wait,
    /// It ends, with an error.
    Leave,
}
