//! A library of C functions that is loaded at run time.

use std::{ffi::CString, mem::ManuallyDrop, path::Path};

use libloading::Library;

/// The reason why a library, or a function of it, cannot be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    #[error("this build of the program is static and loads no shared libraries: use the one for glibc")]
    Static,
    #[error(transparent)]
    System(#[from] libloading::Error),
}

/// A loaded library. It is never unloaded: its worker threads may outlive all objects that were
/// made with it, and its functions may be called at any time.
pub struct NativeLibrary(ManuallyDrop<Library>);

impl NativeLibrary {
    /// Loads the library at `path`.
    ///
    /// # Errors
    /// The system cannot load it, or the program is static: such a program has no loader.
    pub fn load(path: &Path) -> Result<Self, LoadError> {
        if cfg!(all(target_env = "musl", target_feature = "crt-static")) {
            return Err(LoadError::Static);
        }
        // SAFETY: loading runs the library's own initialisers; the user who names the library
        // vouches for them.
        Ok(Self(ManuallyDrop::new(unsafe { Library::new(path)? })))
    }

    /// Returns the function of this name as a value of the function pointer type `F`.
    ///
    /// # Safety
    /// `F` is the type of that function.
    pub unsafe fn function<F: Copy>(&self, name: &str) -> Result<F, LoadError> {
        let name = CString::new(name).expect("no function's name has a zero byte");
        // SAFETY: by this function's own contract; the library stays loaded.
        Ok(*unsafe { self.0.get::<F>(name.as_bytes_with_nul())? })
    }
}
