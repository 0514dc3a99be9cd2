//! What the system tells of the memory of the machine, of this process and of its job.

use std::ptr;

use windows_sys::Win32::System::{
    JobObjects::{
        JOB_OBJECT_LIMIT_JOB_MEMORY, JOB_OBJECT_LIMIT_PROCESS_MEMORY, JOBOBJECT_EXTENDED_LIMIT_INFORMATION,
        JobObjectExtendedLimitInformation, QueryInformationJobObject,
    },
    ProcessStatus::{K32GetProcessMemoryInfo, PROCESS_MEMORY_COUNTERS},
    SystemInformation::{GlobalMemoryStatusEx, MEMORYSTATUSEX},
    Threading::GetCurrentProcess,
};

/// The memory of the machine, in bytes.
pub struct MachineMemory {
    pub total: u64,
    /// The memory that can still be allocated without paging.
    pub free: u64,
}

impl MachineMemory {
    pub fn now() -> Option<Self> {
        let mut status = MEMORYSTATUSEX {
            dwLength: size_of::<MEMORYSTATUSEX>() as u32,
            ..MEMORYSTATUSEX::default()
        };
        // SAFETY: the structure is valid and tells its own size.
        let is_told = unsafe { GlobalMemoryStatusEx(&raw mut status) } != 0;
        is_told.then(|| Self {
            total: status.ullTotalPhys,
            free: status.ullAvailPhys.min(status.ullAvailPageFile),
        })
    }
}

/// The memory of this process, in bytes.
pub struct ProcessMemory {
    pub committed: u64,
    /// The most resident memory so far.
    pub peak: u64,
}

impl ProcessMemory {
    pub fn now() -> Option<Self> {
        let mut counters = PROCESS_MEMORY_COUNTERS::default();
        let size = size_of::<PROCESS_MEMORY_COUNTERS>() as u32;
        // SAFETY: the handle of the own process is always valid, and the structure has the size that is told.
        let is_told = unsafe { K32GetProcessMemoryInfo(GetCurrentProcess(), &raw mut counters, size) } != 0;
        is_told.then_some(Self {
            committed: counters.PagefileUsage as u64,
            peak: counters.PeakWorkingSetSize as u64,
        })
    }
}

/// The most memory that the job of this process, or the process in it, may commit, in bytes; `None` without a limit.
pub fn job_memory_limit() -> Option<u64> {
    let mut limits = JOBOBJECT_EXTENDED_LIMIT_INFORMATION::default();
    let size = size_of::<JOBOBJECT_EXTENDED_LIMIT_INFORMATION>() as u32;
    // SAFETY: no handle stands for the job of this process, and the structure has the size that is told.
    let is_told = unsafe {
        QueryInformationJobObject(
            ptr::null_mut(),
            JobObjectExtendedLimitInformation,
            (&raw mut limits).cast(),
            size,
            ptr::null_mut(),
        )
    } != 0;
    let flags = limits.BasicLimitInformation.LimitFlags;
    let of_job = (flags & JOB_OBJECT_LIMIT_JOB_MEMORY != 0).then_some(limits.JobMemoryLimit);
    let of_process = (flags & JOB_OBJECT_LIMIT_PROCESS_MEMORY != 0).then_some(limits.ProcessMemoryLimit);
    let least = of_job.into_iter().chain(of_process).min()?;
    is_told.then_some(least as u64)
}
