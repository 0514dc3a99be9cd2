//! Exit codes, by which farms decide what to do next. They follow sysexits.h if it has a code for the case.

use batch_render::{
    bench,
    error::{Blame, Error},
};

use super::{failures::FramesFailed, scene_failures::ScenesFailed, signals, stream::PipeClosed};

pub const OK: u8 = 0;
/// Wrong usage; the same command will fail again.
pub const USAGE: u8 = 2;
/// Scene or camera data is wrong, or needs more memory than allowed (EX_DATAERR).
const DATA: u8 = 65;
/// An input file is missing (EX_NOINPUT).
const NO_INPUT: u8 = 66;
/// The system allows no more threads (EX_OSERR).
const SYSTEM: u8 = 71;
/// The output cannot be created (EX_CANTCREAT).
const CANNOT_CREATE: u8 = 73;
/// Writing or reading failed (EX_IOERR).
const IO: u8 = 74;
/// Another job writes the same files (EX_TEMPFAIL).
const BUSY: u8 = 75;
/// The reader of standard output has gone: the code of a process that SIGPIPE ends.
const PIPE_CLOSED: u8 = 141;
/// An error that is none of these; also: some frames failed, and the others are on disk.
const OTHER: u8 = 1;

pub fn code(error: &anyhow::Error) -> u8 {
    if error.is::<PipeClosed>() {
        return PIPE_CLOSED;
    }
    if error
        .downcast_ref::<ScenesFailed>()
        .is_some_and(|failed| failed.are_busy)
    {
        return BUSY;
    }
    let blame = match error.downcast_ref::<FramesFailed>() {
        Some(failed) => failed.blame,
        None => error
            .downcast_ref::<Error>()
            .map(Error::blame)
            .or_else(|| error.downcast_ref::<bench::Error>().map(bench::Error::blame)),
    };
    let Some(blame) = blame else { return OTHER };
    match blame {
        Blame::Usage => USAGE,
        Blame::Data => DATA,
        Blame::MissingInput => NO_INPUT,
        Blame::CannotCreate => CANNOT_CREATE,
        Blame::Io => IO,
        Blame::System => SYSTEM,
        Blame::Busy => BUSY,
        Blame::Cancelled => signals::exit_code(),
    }
}
