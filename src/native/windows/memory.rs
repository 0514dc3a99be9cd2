//! What the system tells of the memory of the machine, of this process and of its job.

use std::{
    os::windows::io::{AsRawHandle, FromRawHandle, OwnedHandle},
    ptr,
};

use windows_sys::Win32::{
    Foundation::HANDLE,
    System::{
        JobObjects::{
            JOB_OBJECT_LIMIT_JOB_MEMORY, JOB_OBJECT_LIMIT_PROCESS_MEMORY, JOBOBJECT_EXTENDED_LIMIT_INFORMATION,
            JOBOBJECTINFOCLASS, JobObjectBasicProcessIdList, JobObjectExtendedLimitInformation,
            QueryInformationJobObject,
        },
        ProcessStatus::{K32GetProcessMemoryInfo, PROCESS_MEMORY_COUNTERS},
        SystemInformation::{GlobalMemoryStatusEx, MEMORYSTATUSEX},
        Threading::{GetCurrentProcess, OpenProcess, PROCESS_QUERY_LIMITED_INFORMATION},
    },
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

/// The memory of a process, in bytes.
pub struct ProcessMemory {
    pub committed: u64,
    /// The most resident memory so far.
    pub peak: u64,
}

impl ProcessMemory {
    pub fn now() -> Option<Self> {
        // SAFETY: a call without arguments, whose result stands for this process and is not closed.
        Self::of(unsafe { GetCurrentProcess() })
    }

    /// The memory of the process of an open handle, which must have the right to ask for it.
    fn of(process: HANDLE) -> Option<Self> {
        let mut counters = PROCESS_MEMORY_COUNTERS::default();
        let size = size_of::<PROCESS_MEMORY_COUNTERS>() as u32;
        // SAFETY: the system refuses handles that are not open, and the structure has the size that is told.
        let is_told = unsafe { K32GetProcessMemoryInfo(process, &raw mut counters, size) } != 0;
        is_told.then_some(Self {
            committed: counters.PagefileUsage as u64,
            peak: counters.PeakWorkingSetSize as u64,
        })
    }
}

/// A limit of the memory that processes of the job of this process may commit, in bytes.
pub struct JobMemory {
    pub limit: u64,
    /// What those that share the limit have committed.
    pub used: u64,
}

impl JobMemory {
    /// The limit of the job and that of each of its processes, where it has them.
    pub fn now() -> Vec<Self> {
        let mut limits = JOBOBJECT_EXTENDED_LIMIT_INFORMATION::default();
        if !query_job(JobObjectExtendedLimitInformation, &mut limits) {
            return Vec::new();
        }
        let own = ProcessMemory::now().map_or(0, |memory| memory.committed);
        let flags = limits.BasicLimitInformation.LimitFlags;
        let of_process = (flags & JOB_OBJECT_LIMIT_PROCESS_MEMORY != 0).then_some(Self {
            limit: limits.ProcessMemoryLimit as u64,
            used: own,
        });
        let of_job = (flags & JOB_OBJECT_LIMIT_JOB_MEMORY != 0).then(|| Self {
            limit: limits.JobMemoryLimit as u64,
            used: own.max(committed_by_job()),
        });
        of_process.into_iter().chain(of_job).collect()
    }
}

/// As `JOBOBJECT_BASIC_PROCESS_ID_LIST`, for many processes.
#[repr(C)]
struct JobProcesses {
    assigned: u32,
    listed: u32,
    ids: [usize; Self::MOST],
}

impl JobProcesses {
    const MOST: usize = 1024;
}

/// What the processes of the job of this process have committed, in bytes; those that may not be asked are left out.
fn committed_by_job() -> u64 {
    let mut processes = JobProcesses {
        assigned: 0,
        listed: 0,
        ids: [0; JobProcesses::MOST],
    };
    // Where there are more of them, the call fails and lists the first ones.
    query_job(JobObjectBasicProcessIdList, &mut processes);
    let ids = processes.ids.iter().take(processes.listed as usize);
    ids.filter_map(|&id| committed_by(id as u32)).sum()
}

/// What a process has committed, in bytes.
fn committed_by(id: u32) -> Option<u64> {
    // SAFETY: a call without pointers.
    let handle = unsafe { OpenProcess(PROCESS_QUERY_LIMITED_INFORMATION, 0, id) };
    if handle.is_null() {
        return None;
    }
    // SAFETY: the handle is open, and nothing else closes it.
    let process = unsafe { OwnedHandle::from_raw_handle(handle) };
    Some(ProcessMemory::of(process.as_raw_handle())?.committed)
}

/// Asks for what the system tells of the job of this process; whether all of it was told.
fn query_job<T>(class: JOBOBJECTINFOCLASS, told: &mut T) -> bool {
    let size = size_of::<T>() as u32;
    // SAFETY: no handle stands for the job of this process, and the structure has the size that is told.
    unsafe {
        QueryInformationJobObject(
            ptr::null_mut(),
            class,
            ptr::from_mut(told).cast(),
            size,
            ptr::null_mut(),
        ) != 0
    }
}
