//! Standard output whose reader has gone.

use std::io;

/// A code of Windows that the standard library has no kind for.
const ERROR_PIPE_NOT_CONNECTED: i32 = 233;

/// Whether an error of standard output says that its reader has gone.
pub fn is_closed_pipe(error: &io::Error) -> bool {
    let is_of_windows = cfg!(windows) && error.raw_os_error() == Some(ERROR_PIPE_NOT_CONNECTED);
    is_of_windows || error.kind() == io::ErrorKind::BrokenPipe
}
