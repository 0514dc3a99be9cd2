//! An offline batch renderer for CPUs: a scene file and a camera path become a sequence of HDR frames.
//!
//! The floors, from the ground up: numbers ([`math`], [`value`]) and [`warnings`]; kinds ([`shape`], [`texture`], [`material`],
//! [`light`], [`camera`], [`sampler`], [`filter`]); what is traced ([`accel`], [`scene`]); what light does ([`integrator`],
//! [`film`]); frames and files in ([`render`], [`describe`], [`assets`]); scenes and files out ([`compile`], [`output`]); jobs
//! ([`batch`], [`mod@bench`]). A module uses the floors below its own, never one above.

pub mod accel;
pub mod assets;
pub mod batch;
pub mod bench;
pub mod bsdf;
pub mod camera;
pub mod compare;
pub mod compile;
pub mod denoise;
pub mod describe;
pub mod error;
pub mod film;
pub mod filter;
pub mod geometry;
pub mod integrator;
mod kind;
pub mod light;
pub mod material;
pub mod math;
mod native;
pub mod output;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod shape;
pub mod simd;
pub mod texture;
pub mod value;
#[cfg(feature = "viewer")]
pub mod viewer;
pub mod warnings;

#[cfg(windows)]
pub use native::windows;
