//! The memory and the processor time of a process, as Windows tells them.

use batch_render::windows::{JobMemory, MachineMemory, ProcessMemory};
use cpu_time::ProcessTime;

/// Whether the address space of the process has a limit, which Windows does not know.
pub fn has_limited_addresses() -> bool {
    false
}

/// The memory of the machine, or the limit of the process's job, in bytes.
pub fn total() -> Option<u64> {
    let machine = MachineMemory::now().map(|memory| memory.total);
    let of_job = JobMemory::now().into_iter().map(|memory| memory.limit);
    machine.into_iter().chain(of_job).min()
}

/// The memory that the process can still allocate, in bytes: the least of the free memory of the machine and the rests of the
/// limits of its job. `None` if the system does not report it.
pub fn free() -> Option<u64> {
    let machine = MachineMemory::now().map(|memory| memory.free);
    let of_job = JobMemory::now()
        .into_iter()
        .map(|memory| memory.limit.saturating_sub(memory.used));
    machine.into_iter().chain(of_job).min()
}

/// The peak of resident memory so far, in bytes; `None` if the system does not report it.
pub fn peak() -> Option<u64> {
    ProcessMemory::now().map(|memory| memory.peak)
}

/// The processor time of all threads so far, in seconds; `None` if the system does not report it.
pub fn cpu_seconds() -> Option<f64> {
    let time = ProcessTime::try_now().ok()?;
    Some(time.as_duration().as_secs_f64())
}
