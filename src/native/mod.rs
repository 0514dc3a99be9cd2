//! C libraries that are loaded at run time, which the build neither needs nor links; functions of C that a static program lacks;
//! calls of Windows.

mod embree;
mod library;
#[cfg(all(target_arch = "x86_64", target_env = "musl"))]
mod memory;
mod oidn;
#[cfg(windows)]
pub mod windows;

pub use embree::{Coherence, Embree, EmbreeError, EmbreeQuality, RayHit, RayHit16};
pub use oidn::{Oidn, OidnError, OidnImages};
