//! Bindings to Intel Open Image Denoise 2, which is loaded at run time. The build neither needs nor links it.
//!
//! Only the functions that denoising a picture calls are declared, after the library's public header (oidn.h of version 2).

use std::{
    ffi::{CStr, c_char, c_int, c_void},
    path::Path,
    ptr,
};

use super::library::{LoadError, NativeLibrary};

/// The oldest version whose functions are those declared here.
const OLDEST: c_int = 20000;

/// OIDN_DEVICE_TYPE_CPU, OIDN_FORMAT_FLOAT3, OIDN_ERROR_NONE.
const CPU: c_int = 1;
const FLOAT3: c_int = 3;
const NO_ERROR: c_int = 0;

/// The reason why Open Image Denoise cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum OidnError {
    #[error(
        "cannot load Open Image Denoise ({0}): install it, or name {name} with --oidn-lib or its folder with OIDN_DIR",
        name = Oidn::LIBRARY
    )]
    Load(String),
    #[error("cannot load Open Image Denoise: {}", LoadError::Static)]
    Static,
    #[error("Open Image Denoise is too old: it has version {0}, and 2.0 or newer is needed")]
    Old(String),
    #[error("Open Image Denoise gives no device for this processor")]
    Device,
    #[error("Open Image Denoise has failed: {0}")]
    Failed(String),
}

impl OidnError {
    /// The library could not be loaded, with the system's message.
    fn load(cause: LoadError) -> Self {
        match cause {
            LoadError::Static => Self::Static,
            LoadError::System(cause) => {
                let source = std::error::Error::source(&cause);
                Self::Load(source.map_or_else(|| cause.to_string(), ToString::to_string))
            }
        }
    }
}

/// The functions of the library.
struct Functions {
    new_device: unsafe extern "C" fn(c_int) -> *mut c_void,
    set_device_int: unsafe extern "C" fn(*mut c_void, *const c_char, c_int),
    get_device_int: unsafe extern "C" fn(*mut c_void, *const c_char) -> c_int,
    set_device_bool: unsafe extern "C" fn(*mut c_void, *const c_char, bool),
    commit_device: unsafe extern "C" fn(*mut c_void),
    device_error: unsafe extern "C" fn(*mut c_void, *mut *const c_char) -> c_int,
    release_device: unsafe extern "C" fn(*mut c_void),
    new_filter: unsafe extern "C" fn(*mut c_void, *const c_char) -> *mut c_void,
    set_image: unsafe extern "C" fn(*mut c_void, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize),
    set_bool: unsafe extern "C" fn(*mut c_void, *const c_char, bool),
    commit_filter: unsafe extern "C" fn(*mut c_void),
    execute: unsafe extern "C" fn(*mut c_void),
    release_filter: unsafe extern "C" fn(*mut c_void),
}

impl Functions {
    fn load(library: &NativeLibrary) -> Result<Self, LoadError> {
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the declared type is that of the function of this name in the header of version 2.
                unsafe { library.function($name)? }
            };
        }
        Ok(Self {
            new_device: function!("oidnNewDevice"),
            set_device_int: function!("oidnSetDeviceInt"),
            get_device_int: function!("oidnGetDeviceInt"),
            set_device_bool: function!("oidnSetDeviceBool"),
            commit_device: function!("oidnCommitDevice"),
            device_error: function!("oidnGetDeviceError"),
            release_device: function!("oidnReleaseDevice"),
            new_filter: function!("oidnNewFilter"),
            set_image: function!("oidnSetSharedFilterImage"),
            set_bool: function!("oidnSetFilterBool"),
            commit_filter: function!("oidnCommitFilter"),
            execute: function!("oidnExecuteFilter"),
            release_filter: function!("oidnReleaseFilter"),
        })
    }
}

/// Open Image Denoise on the processor.
pub struct Oidn {
    functions: Functions,
    device: *mut c_void,
    version: c_int,
}

// SAFETY: a device may be used by one thread after the other; `denoise` takes it alone.
unsafe impl Send for Oidn {}

/// A picture for the denoiser: red, green and blue, or x, y and z, of each pixel beside each other.
pub struct OidnImages<'a> {
    pub width: usize,
    pub height: usize,
    pub color: &'a mut [f32],
    pub albedo: &'a mut [f32],
    pub normal: &'a mut [f32],
    pub output: &'a mut [f32],
}

impl Oidn {
    /// The name by which systems with the library find it.
    pub const LIBRARY: &str = match cfg!(windows) {
        true => "OpenImageDenoise.dll",
        false => "libOpenImageDenoise.so.2",
    };

    /// The folder in a release of the library that has it.
    pub const FOLDER: &str = if cfg!(windows) { "bin" } else { "lib" };

    /// Loads the library at `path`; without one that of the system.
    ///
    /// # Errors
    /// There is none, it is too old, or it does not run here.
    pub fn load(path: Option<&Path>, threads: usize) -> Result<Self, OidnError> {
        let library = NativeLibrary::load(path.unwrap_or(Path::new(Self::LIBRARY)));
        let library = library.map_err(OidnError::load)?;
        // The functions of version 1 have other names.
        let functions = Functions::load(&library).map_err(|_| OidnError::Old("1".to_owned()))?;
        // SAFETY: the type of a device is a number.
        let device = unsafe { (functions.new_device)(CPU) };
        if device.is_null() {
            return Err(OidnError::Device);
        }
        // SAFETY: the device is valid, and the names end in a zero byte.
        let version = unsafe {
            (functions.set_device_int)(device, c"numThreads".as_ptr(), threads as c_int);
            (functions.set_device_bool)(device, c"setAffinity".as_ptr(), false);
            (functions.commit_device)(device);
            (functions.get_device_int)(device, c"version".as_ptr())
        };
        let oidn = Self {
            functions,
            device,
            version,
        };
        if version < OLDEST {
            return Err(OidnError::Old(oidn.version()));
        }
        oidn.check()?;
        Ok(oidn)
    }

    /// The version of the library, such as 2.3.1.
    pub fn version(&self) -> String {
        let v = self.version;
        format!("{}.{}.{}", v / 10000, v / 100 % 100, v % 100)
    }

    /// Denoises a picture of light without limits, whose albedo and normals have little noise.
    ///
    /// # Errors
    /// An error with the library's message.
    pub fn denoise(&mut self, images: &mut OidnImages<'_>) -> Result<(), OidnError> {
        let OidnImages { width, height, .. } = *images;
        let numbers = 3 * width * height;
        let f = &self.functions;
        let named: [(&CStr, &mut [f32]); 4] = [
            (c"color", images.color),
            (c"albedo", images.albedo),
            (c"normal", images.normal),
            (c"output", images.output),
        ];
        // SAFETY: the device is valid, names end in a zero byte, and every image has the numbers of `width` times `height`
        // pixels and lives until the filter is released.
        unsafe {
            let filter = (f.new_filter)(self.device, c"RT".as_ptr());
            for (name, image) in named {
                assert_eq!(image.len(), numbers, "three numbers a pixel");
                let data = image.as_mut_ptr().cast();
                (f.set_image)(filter, name.as_ptr(), data, FLOAT3, width, height, 0, 0, 0);
            }
            (f.set_bool)(filter, c"hdr".as_ptr(), true);
            (f.commit_filter)(filter);
            (f.execute)(filter);
            (f.release_filter)(filter);
        }
        self.check()
    }

    /// The error since the last call, if any.
    fn check(&self) -> Result<(), OidnError> {
        let mut message = ptr::null();
        // SAFETY: the device is valid; the message lives until the next call.
        let (error, text) = unsafe {
            let error = (self.functions.device_error)(self.device, &raw mut message);
            let text = (!message.is_null()).then(|| CStr::from_ptr(message).to_string_lossy().into_owned());
            (error, text)
        };
        match error {
            NO_ERROR => Ok(()),
            _ => Err(OidnError::Failed(text.unwrap_or_else(|| format!("error {error}")))),
        }
    }
}

impl Drop for Oidn {
    fn drop(&mut self) {
        // SAFETY: the device is valid and not used afterwards.
        unsafe { (self.functions.release_device)(self.device) };
    }
}
