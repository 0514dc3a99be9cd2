//! What the system tells of files.

use std::{fs::OpenOptions, os::windows::io::AsRawHandle, path::Path};

use windows_sys::Win32::Storage::FileSystem::{BY_HANDLE_FILE_INFORMATION, GetFileInformationByHandle};

/// The volume of an existing file and its number there: equal for all its names.
pub fn file_identity(path: &Path) -> Option<(u32, u64)> {
    let file = OpenOptions::new().read(true).open(path).ok()?;
    let mut told = BY_HANDLE_FILE_INFORMATION::default();
    // SAFETY: the handle is that of an open file, and the structure is valid.
    let is_told = unsafe { GetFileInformationByHandle(file.as_raw_handle(), &raw mut told) } != 0;
    let number = u64::from(told.nFileIndexHigh) << 32 | u64::from(told.nFileIndexLow);
    is_told.then_some((told.dwVolumeSerialNumber, number))
}
