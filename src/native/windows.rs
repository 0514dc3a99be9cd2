//! Calls of Windows.

mod console;
mod files;
mod memory;

pub use console::{ConsoleEvent, listen};
pub use files::file_identity;
pub use memory::{MachineMemory, ProcessMemory, job_memory_limit};
