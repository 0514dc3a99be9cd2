//! The behaviour if another job writes the same files.

/// The behaviour of a job if another one writes the same files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IfBusy {
    /// It waits until the other one has ended.
    #[default]
    Wait,
    /// It ends, with an error.
    Leave,
}
