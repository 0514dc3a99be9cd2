//! Jobs: a scene and a camera path become files, frame by frame.
//!
//! A [`Request`] is what somebody wants; [`Plan::new`] turns it into frames, files and settings, or says why not,
//! without touching a pixel; [`run`] renders them, writing each frame while the next one renders.

mod existing;
mod open;
mod passes;
mod plan;
mod run;
mod summary;
mod turntable;

pub mod range;

pub use existing::Existing;
pub use open::open;
pub use plan::{Plan, PlannedFrame, Request};
pub use range::FrameRange;
pub use run::{Observer, run};
pub use summary::Summary;
pub use turntable::Turntable;
