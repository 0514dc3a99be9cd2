//! Calls of Windows.

mod console;
mod memory;

pub use console::{ConsoleEvent, listen};
pub use memory::{MachineMemory, ProcessMemory, job_memory_limit};
