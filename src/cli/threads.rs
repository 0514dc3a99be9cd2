//! The threads of a job.

use batch_render::error::Error;

/// The threads that a job renders on; one for each processor where no number is given.
pub fn threads(number: Option<u16>) -> Result<rayon::ThreadPool, Error> {
    let what = match number {
        Some(1) => "a thread to render on".to_owned(),
        Some(n) => format!("{n} threads to render on"),
        None => "the threads to render on".to_owned(),
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(number.unwrap_or(0)))
        .thread_name(|i| format!("render {i}"))
        .build()
        .map_err(|cause| Error::threads(&what, &cause))
}
