//! The threads of a job.

use anyhow::Context;

/// The threads that a job renders on; one for each processor where no number is given.
pub fn threads(number: Option<u16>) -> anyhow::Result<rayon::ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(number.unwrap_or(0)))
        .thread_name(|i| format!("render {i}"))
        .build()
        .context("cannot start threads")
}
