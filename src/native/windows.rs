//! Calls of Windows.

mod console;
mod files;
mod memory;
mod processors;

pub use console::{ConsoleEvent, listen};
pub use files::file_identity;
pub use memory::{JobMemory, MachineMemory, ProcessMemory};
pub use processors::allowed_processors;
