//! SIGINT and SIGTERM: the first asks the job to stop, a second ends the process at once. SIGUSR1 asks for the frame as it
//! stands. On Windows these are Ctrl-C, Ctrl-Break and a console that is closed, and nothing asks for the frame.

#[cfg(not(windows))]
mod unix;
#[cfg(windows)]
mod windows;

use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicUsize, Ordering},
};

use batch_render::render::{Cancel, ShowRequest};

#[cfg(not(windows))]
use unix as system;
#[cfg(windows)]
use windows as system;

pub use system::survive_large_files;

/// The number of the signal of Ctrl-C.
const SIGINT: i32 = 2;

/// The signal that came first, 0 for none.
static RECEIVED: AtomicUsize = AtomicUsize::new(0);

/// The job that signals are for: the last one that listens.
static JOB: Mutex<Option<(Arc<Cancel>, Arc<ShowRequest>)>> = Mutex::new(None);

/// From now on SIGINT and SIGTERM cancel what `cancel` is given to, and SIGUSR1 asks for what `show` is given to. A signal that
/// the parent process has set to be ignored, as `nohup` and shells do for background jobs, stays ignored. A signal that came
/// between two jobs cancels the second.
pub fn listen(cancel: Arc<Cancel>, show: Arc<ShowRequest>) -> anyhow::Result<()> {
    let mut job = JOB.lock().unwrap_or_else(PoisonError::into_inner);
    let is_first = job.replace((Arc::clone(&cancel), show)).is_none();
    drop(job);
    if is_received() {
        cancel.cancel();
    }
    match is_first {
        true => system::start(ask_to_stop, ask_to_show),
        false => Ok(()),
    }
}

/// The job that signals are for.
fn job() -> Option<(Arc<Cancel>, Arc<ShowRequest>)> {
    JOB.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Asks the job to stop.
fn ask_to_stop(signal: i32) {
    let _ = RECEIVED.compare_exchange(0, signal as usize, Ordering::SeqCst, Ordering::SeqCst);
    if let Some((cancel, _)) = job() {
        cancel.cancel();
    }
}

/// Asks for the frame as it stands.
fn ask_to_show() {
    if let Some((_, show)) = job() {
        show.ask();
    }
}

/// Whether a signal has asked to stop.
pub fn is_received() -> bool {
    RECEIVED.load(Ordering::SeqCst) != 0
}

/// 128 and the number of the signal: 130 after SIGINT, 143 after SIGTERM.
pub fn exit_code() -> u8 {
    match RECEIVED.load(Ordering::SeqCst) {
        0 => 128 + SIGINT as u8,
        signal => 128 + signal as u8,
    }
}
