//! Events of the console of Windows, which stand for signals.

use std::{
    process::exit,
    sync::{
        OnceLock,
        atomic::{AtomicBool, Ordering},
    },
};

use anyhow::Context;
use batch_render::windows::{ConsoleEvent, listen};

/// The numbers of the signals of Ctrl-C, Ctrl-Break and a console that is closed.
const SIGINT: i32 = 2;
const SIGBREAK: i32 = 21;
const SIGTERM: i32 = 15;

/// Whether a signal has come already.
static AGAIN: AtomicBool = AtomicBool::new(false);

/// Stops the job.
static STOP: OnceLock<fn(i32)> = OnceLock::new();

/// Starts to listen to the console, whose events are passed to `stop`. None of them asks for the frame as it stands.
pub fn start(stop: fn(i32), _show: fn()) -> anyhow::Result<()> {
    STOP.get_or_init(|| stop);
    listen(hear).context("cannot handle Ctrl-C")
}

fn hear(event: ConsoleEvent) {
    let signal = match event {
        ConsoleEvent::Interrupt => SIGINT,
        ConsoleEvent::Break => SIGBREAK,
        ConsoleEvent::Close => SIGTERM,
    };
    if AGAIN.swap(true, Ordering::SeqCst) {
        exit(128 + signal);
    }
    if let Some(stop) = STOP.get() {
        stop(signal);
    }
}

/// Files have no limit of size here.
pub fn survive_large_files() {}
