//! The arguments of the command line.

use std::ffi::OsString;

/// The arguments, the program first. The shells of Windows leave patterns of file names (`*.glb`) to
/// programs; a pattern without a file stays.
pub fn arguments() -> impl Iterator<Item = OsString> {
    #[cfg(windows)]
    return wild::args_os();
    #[cfg(not(windows))]
    std::env::args_os()
}
