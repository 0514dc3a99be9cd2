//! Libraries in C that are loaded at run time: nothing is linked, and nothing is needed to build.

mod embree;
mod library;

pub use embree::{Coherence, Embree, EmbreeError, EmbreeQuality, RayHit, RayHit16};
