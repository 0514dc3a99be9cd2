//! Signals of Unix.

use std::{
    fs::read_to_string,
    sync::{Arc, atomic::AtomicBool},
    thread::Builder,
};

use anyhow::Context;
use batch_render::error::Error;
use signal_hook::{
    consts::{SIGINT, SIGTERM, SIGUSR1, SIGXFSZ},
    flag,
    iterator::Signals,
};

/// Starts the thread that listens, which passes signals to `stop` and SIGUSR1 to `show`.
pub fn start(stop: fn(i32), show: fn()) -> anyhow::Result<()> {
    let again = Arc::new(AtomicBool::new(false));
    let handled: Vec<i32> = [SIGINT, SIGTERM].into_iter().filter(|s| !is_ignored(*s)).collect();
    for &signal in &handled {
        // In this order: the second signal finds `again` set and ends the process with the usual code.
        flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&again))
            .context("cannot handle signals")?;
        flag::register(signal, Arc::clone(&again)).context("cannot handle signals")?;
    }
    let heard = handled.iter().copied().chain([SIGUSR1]);
    let mut signals = Signals::new(heard).context("cannot handle signals")?;
    let listen = move || {
        for signal in signals.forever() {
            match signal {
                SIGUSR1 => show(),
                _ => stop(signal),
            }
        }
    };
    let thread = Builder::new().name("signals".to_owned()).spawn(listen);
    thread
        .map(drop)
        .map_err(|cause| Error::threads("the thread that listens to signals", &cause).into())
}

/// From now on a file beyond the limit of the process (`ulimit -f`) is an error of writing and does not end the process.
pub fn survive_large_files() {
    // Without a handler the signal ends the process; what it does does not matter.
    let _ = flag::register(SIGXFSZ, Arc::default());
}

/// Whether the process was started with this signal ignored. Only Linux tells without unsafe code: elsewhere no signal
/// counts as ignored.
fn is_ignored(signal: i32) -> bool {
    let status = read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
