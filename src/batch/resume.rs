//! The parts that let a job go on after a kill, a failure or a change: fingerprints, checkpoints, locks, signals.

pub(super) mod checkpoint;
pub(super) mod failure;
pub(super) mod fingerprint;
pub(super) mod frame_interrupts;
pub(super) mod job_lock;
pub(super) mod stale;
