//! C libraries that are loaded at run time. The build neither needs nor links them.

mod embree;
mod library;
mod oidn;

pub use embree::{Coherence, Embree, EmbreeError, EmbreeQuality, RayHit, RayHit16};
pub use oidn::{Oidn, OidnError, OidnImages};
