//! An offline batch renderer for CPUs: a scene file and a camera path become a sequence of HDR frames.
//!
//! The floors, from the ground up: [`math`], [`value`]; the kinds ([`shape`], ...); [`accel`]. A module uses the
//! floors below its own, never one above.

pub mod accel;
pub mod assets;
pub mod film;
mod kind;
pub mod math;
pub mod output;
pub mod shape;
pub mod value;
