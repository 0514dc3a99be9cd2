//! Accelerators side by side: the same rays, in one run, with Embree beside them where its library is at hand.
//!
//! Four kinds of rays are made from a scene by a fixed seed (`rays`); every cell of the table, an accelerator and a kind
//! of rays, is measured in turn, over and over, so that a machine that slows down slows all of them (`run`).

mod html;
mod rays;
mod report;
mod run;
mod tracer;

pub use html::page;
pub use rays::{Buffers, RayKind, SIDE};
pub use report::{BuildRow, Cell, Report};
pub use run::{BenchObserver, BenchOptions, Error, run};
