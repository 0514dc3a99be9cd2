//! Jobs: a scene and a camera path become files, frame by frame.
//!
//! [`Job::open`] reads a scene and turns a [`Request`] into a [`Plan`] of frames, files and settings; [`Job::load`] loads the
//! files of the scene; [`Job::run`] renders the frames, and writes each one while the next one renders.

mod as_text;
mod cameras;
mod checkpoint;
pub mod denoise;
mod denoise_options;
mod encoding;
mod events;
mod existing;
mod failure;
mod fingerprint;
mod frame_interrupts;
mod frame_rate;
mod if_busy;
pub mod inventory;
mod job;
mod job_lock;
mod memory;
mod merge;
pub mod metadata;
mod metering;
mod part;
mod passes;
mod patterns;
mod picture;
mod plan;
mod request;
mod rig;
mod run;
mod sidecars;
mod sight;
mod stale;
mod summary;
mod targets;
mod time_limit;
mod turntable;

pub mod range;

pub use denoise_options::{DenoiseOptions, FilterKind};
pub use events::{JobEvent, Observer};
pub use existing::Existing;
pub use failure::{FrameError, FrameFailure, OnFailure};
pub use fingerprint::{Fingerprint, InputHash};
pub use if_busy::IfBusy;
pub use inventory::Inventory;
pub use job::Job;
pub use merge::merge;
pub use part::{JobPart, PartBase, PartOrder, PartSpec};
pub use picture::PicturePlan;
pub use plan::{FilePlan, Plan, PlannedFrame};
pub use range::FrameRange;
pub use request::{Policy, Request};
pub use rig::CameraRig;
pub use run::run;
pub use stale::{Stale, StaleReason, Survey};
pub use summary::{SceneFigures, Summary};
pub use turntable::Turntable;
