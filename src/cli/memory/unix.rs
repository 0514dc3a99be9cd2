//! The memory and the processor time of a process, as Linux tells them in `/proc`; other systems of Unix tell nothing.

use std::{
    fs::read_to_string,
    path::{Path, PathBuf},
};

/// Whether the address space of the process has a limit (`ulimit -v`).
pub fn has_limited_addresses() -> bool {
    of_address_space().is_some()
}

/// The memory of the machine or of the process's control groups, in bytes.
pub fn total() -> Option<u64> {
    let machine = kibibytes("/proc/meminfo", "MemTotal:");
    machine.into_iter().chain(groups().map(|group| group.limit)).min()
}

/// The memory that the process can still allocate, in bytes: the least of the free memory of the machine, the limits of its
/// control groups (version 2) and that of its address space. `None` if the system does not report it.
pub fn free() -> Option<u64> {
    let machine = kibibytes("/proc/meminfo", "MemAvailable:");
    let of_groups = groups().map(|group| group.limit.saturating_sub(group.used)).min();
    [machine, of_groups, of_address_space()].into_iter().flatten().min()
}

/// The peak of resident memory so far, in bytes; `None` if the system does not report it.
pub fn peak() -> Option<u64> {
    kibibytes("/proc/self/status", "VmHWM:")
}

/// The processor time of all threads so far, in seconds, to a hundredth; `None` if the system does not report it.
pub fn cpu_seconds() -> Option<f64> {
    const TICKS_PER_SECOND: f64 = 100.0;
    let text = read_to_string("/proc/self/stat").ok()?;
    // The name of the program, in parentheses, may contain spaces.
    let (_, fields) = text.rsplit_once(')')?;
    let ticks = fields
        .split_whitespace()
        .skip(11)
        .take(2)
        .map(|field| field.parse::<u64>().ok());
    let sum: u64 = ticks.sum::<Option<u64>>()?;
    Some(sum as f64 / TICKS_PER_SECOND)
}

/// The bytes of a line such as `VmHWM:  1234 kB`.
fn kibibytes(file: &str, name: &str) -> Option<u64> {
    let text = read_to_string(file).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kibibytes * 1024)
}

/// The memory of a control group, in bytes.
struct Group {
    limit: u64,
    used: u64,
}

/// The control groups of the process (version 2) that have a limit.
fn groups() -> impl Iterator<Item = Group> {
    let list = read_to_string("/proc/self/cgroup").unwrap_or_default();
    let own = list.lines().find_map(|l| l.strip_prefix("0::/").map(PathBuf::from));
    let folders: Vec<PathBuf> = own.iter().flat_map(|own| own.ancestors()).map(Path::to_owned).collect();
    folders.into_iter().filter_map(|folder| {
        let folder = Path::new("/sys/fs/cgroup").join(folder);
        let number = |file: &str| read_to_string(folder.join(file)).ok()?.trim().parse().ok();
        Some(Group {
            limit: number("memory.max")?,
            used: number("memory.current")?,
        })
    })
}

/// The remaining bytes of `ulimit -v`; `None` without a limit.
fn of_address_space() -> Option<u64> {
    let limits = read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|l| l.strip_prefix("Max address space"))?;
    let most: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(most.saturating_sub(kibibytes("/proc/self/status", "VmSize:")?))
}
