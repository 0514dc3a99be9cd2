//! SIGINT and SIGTERM: the first asks the job to stop, a second ends the process at once. SIGUSR1 asks for the frame as it
//! stands.

use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicBool, AtomicUsize, Ordering},
};

use anyhow::Context;
use batch_render::{
    error::Error,
    render::{Cancel, ShowRequest},
};
use signal_hook::{
    consts::{SIGINT, SIGTERM, SIGUSR1, SIGXFSZ},
    flag,
};

/// The signal that came first, 0 for none.
static RECEIVED: AtomicUsize = AtomicUsize::new(0);

/// The job that signals are for: the last one that listens.
static JOB: Mutex<Option<(Arc<Cancel>, Arc<ShowRequest>)>> = Mutex::new(None);

/// From now on SIGINT and SIGTERM cancel what `cancel` is given to, and SIGUSR1 asks for what `show` is given to. A signal that
/// the parent process has set to be ignored, as `nohup` and shells do for background jobs, stays ignored. A signal that came between
/// two jobs cancels the second.
pub fn listen(cancel: Arc<Cancel>, show: Arc<ShowRequest>) -> anyhow::Result<()> {
    let mut job = JOB.lock().unwrap_or_else(PoisonError::into_inner);
    let is_first = job.replace((Arc::clone(&cancel), show)).is_none();
    drop(job);
    if is_received() {
        cancel.cancel();
    }
    match is_first {
        true => start(),
        false => Ok(()),
    }
}

/// Starts the thread that listens.
fn start() -> anyhow::Result<()> {
    let again = Arc::new(AtomicBool::new(false));
    let handled: Vec<i32> = [SIGINT, SIGTERM].into_iter().filter(|s| !is_ignored(*s)).collect();
    for &signal in &handled {
        // In this order: the second signal finds `again` set and ends the process with the usual code.
        flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&again))
            .context("cannot handle signals")?;
        flag::register(signal, Arc::clone(&again)).context("cannot handle signals")?;
    }
    let heard = handled.iter().copied().chain([SIGUSR1]);
    let mut signals = signal_hook::iterator::Signals::new(heard).context("cannot handle signals")?;
    let listen = move || {
        for signal in signals.forever() {
            let job = JOB.lock().unwrap_or_else(PoisonError::into_inner).clone();
            let Some((cancel, show)) = job else { continue };
            if signal == SIGUSR1 {
                show.ask();
                continue;
            }
            let _ = RECEIVED.compare_exchange(0, signal as usize, Ordering::SeqCst, Ordering::SeqCst);
            cancel.cancel();
        }
    };
    let thread = std::thread::Builder::new().name("signals".to_owned()).spawn(listen);
    thread
        .map(drop)
        .map_err(|cause| Error::threads("the thread that listens to signals", &cause).into())
}

/// Whether a signal has asked to stop.
pub fn is_received() -> bool {
    RECEIVED.load(Ordering::SeqCst) != 0
}

/// From now on a file beyond the limit of the process (`ulimit -f`) is an error of writing and does not end the process.
pub fn survive_large_files() {
    // Without a handler the signal ends the process; what it does does not matter.
    let _ = flag::register(SIGXFSZ, Arc::default());
}

/// Whether the process was started with this signal ignored. Only Linux tells without unsafe code: elsewhere no signal
/// counts as ignored.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// 130 after SIGINT, 143 after SIGTERM.
pub fn exit_code() -> u8 {
    match RECEIVED.load(Ordering::SeqCst) {
        0 => 128 + SIGINT as u8,
        signal => 128 + signal as u8,
    }
}
