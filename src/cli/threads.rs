//! The threads of a job.

use std::hint::black_box;

use batch_render::error::Error;

/// The stack of a thread, in bytes: the standard library's default.
const STACK: usize = 2 << 20;

/// The address space that the program needs beside the stacks to say what has failed, in bytes.
const ROOM: usize = 32 << 20;

/// The threads that a job renders on; one for each processor where no number is given.
pub fn threads(number: Option<u16>) -> Result<rayon::ThreadPool, Error> {
    let what = match number {
        Some(1) => "a thread to render on".to_owned(),
        Some(n) => format!("{n} threads to render on"),
        None => "the threads to render on".to_owned(),
    };
    if let Some(number) = number {
        room_for(usize::from(number)).map_err(|cause| Error::threads(&what, &cause))?;
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(number.map(usize::from).or_else(allowed_processors).unwrap_or(0))
        .stack_size(STACK)
        .thread_name(|i| format!("render {i}"))
        .build()
        .map_err(|cause| Error::threads(&what, &cause))
}

/// How many processors the process may use, where the standard library does not know it.
#[cfg(windows)]
fn allowed_processors() -> Option<usize> {
    batch_render::windows::allowed_processors()
}

/// How many processors the process may use, where the standard library does not know it: nowhere.
#[cfg(not(windows))]
fn allowed_processors() -> Option<usize> {
    None
}

/// An error if the address space does not hold the stacks of so many threads.
///
/// The threads that start would take the space up one by one, and the last bytes could be missing in any
/// allocation, which ends the process without a message.
fn room_for(threads: usize) -> Result<(), std::collections::TryReserveError> {
    let mut stacks: Vec<u8> = Vec::new();
    let taken = stacks.try_reserve_exact(threads.saturating_mul(STACK).saturating_add(ROOM));
    // The compiler may otherwise leave the allocation out.
    black_box(stacks.as_mut_ptr());
    taken
}
