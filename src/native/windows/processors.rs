//! What the system tells of processors.

use windows_sys::Win32::System::Threading::{GetCurrentProcess, GetProcessAffinityMask};

/// How many processors this process may use, where an affinity of its own or of its job leaves out some of the machine's.
pub fn allowed_processors() -> Option<usize> {
    let (mut own, mut of_machine) = (0_usize, 0_usize);
    // SAFETY: the handle of the own process is always valid, and both masks are.
    let is_told = unsafe { GetProcessAffinityMask(GetCurrentProcess(), &raw mut own, &raw mut of_machine) } != 0;
    // Both masks are empty for a process with threads in more than one group of processors.
    (is_told && own != of_machine).then_some(own.count_ones() as usize)
}
