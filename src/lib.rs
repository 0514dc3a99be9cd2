//! An offline batch renderer for CPUs: a scene file and a camera path become a sequence of HDR frames.
//!
//! The floors, from the ground up: [`math`], [`value`]; the kinds ([`shape`], ...); [`accel`]. A module uses the
//! floors below its own, never one above.

pub mod accel;
pub mod filter;
mod kind;
pub mod light;
pub mod material;
pub mod math;
pub mod sampler;
pub mod shape;
pub mod texture;
pub mod value;
