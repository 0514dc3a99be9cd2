//! A benchmark of all accelerators on the same rays, and of Embree if its library is available.
//!
//! Four kinds of rays are generated from a scene with a fixed seed (`rays`). Each pair of an
//! accelerator and a kind of rays is measured in turn, over and over, so that a slowdown of the
//! machine affects all of them alike (`run`). Apart from these, [`picture`] measures where the time of a whole picture goes.

mod html;
pub mod picture;
mod rays;
mod report;
mod run;
mod tracer;

pub use html::page;
pub use picture::{PictureReport, Subject};
pub use rays::{Buffers, RayKind, SIDE};
pub use report::{BuildRow, Cell, Report};
pub use run::{BenchObserver, BenchOptions, Error, run};
