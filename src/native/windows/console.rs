//! What the console tells its processes.

use std::{io, sync::OnceLock, thread};

use windows_sys::{
    Win32::System::Console::{CTRL_BREAK_EVENT, CTRL_C_EVENT, CTRL_LOGOFF_EVENT, SetConsoleCtrlHandler},
    core::BOOL,
};

/// An event of the console.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConsoleEvent {
    /// Ctrl-C.
    Interrupt,
    /// Ctrl-Break.
    Break,
    /// The console is closed or the machine is shut down. The system ends the process after some seconds.
    Close,
}

static HEAR: OnceLock<fn(ConsoleEvent)> = OnceLock::new();

/// From now on events do not end the process, but are passed to `hear`, each on a thread of its own. Only the first call counts.
pub fn listen(hear: fn(ConsoleEvent)) -> io::Result<()> {
    if HEAR.set(hear).is_err() {
        return Ok(());
    }
    // SAFETY: the handler is a function that lives as long as the process.
    match unsafe { SetConsoleCtrlHandler(Some(handle), 1) } {
        0 => Err(io::Error::last_os_error()),
        _ => Ok(()),
    }
}

unsafe extern "system" fn handle(event: u32) -> BOOL {
    let Some(hear) = HEAR.get() else { return 0 };
    match event {
        CTRL_C_EVENT => hear(ConsoleEvent::Interrupt),
        CTRL_BREAK_EVENT => hear(ConsoleEvent::Break),
        // Only services and what they start get this, whichever user logs off: their jobs go on.
        CTRL_LOGOFF_EVENT => {}
        _ => {
            hear(ConsoleEvent::Close);
            // The process ends when this function returns.
            loop {
                thread::park();
            }
        }
    }
    1
}
