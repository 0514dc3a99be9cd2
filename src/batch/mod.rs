//! Jobs: a scene and a camera path become files, frame by frame.
//!
//! [`Job::open`] reads a scene and turns a [`Request`] into a [`Plan`] of frames, files and settings; [`Job::load`] loads the
//! files of the scene; [`Job::run`] renders the frames, and writes each one while the next one renders.
//!
//! Three folders: `plan` decides what a job does, `resume` lets it go on after a kill or a failure, `products` makes the files
//! beside the pictures.

mod as_text;
mod events;
mod frame_scenes;
pub mod inventory;
mod job;
mod plan;
mod products;
mod resume;
mod run;
mod scenes;
mod sight;
mod summary;
mod writing;

pub use events::{JobEvent, Observer};
pub use frame_scenes::time_in_frames;
pub use inventory::Inventory;
pub use job::Job;
pub use plan::{
    FilePlan, Plan, PlannedFrame,
    denoise_options::{DenoiseOptions, DenoiseSteps, FilterKind},
    existing::Existing,
    if_busy::IfBusy,
    part::{JobPart, PartBase, PartOrder, PartSpec},
    patterns::named_files,
    picture::PicturePlan,
    range::{self, FrameRange},
    request::{Policy, Request, TakenFrames},
    rig::CameraRig,
    turntable::{Turn, Turntable},
    views::{ViewSet, Views},
};
pub use products::{
    coco::categories::CategoryKind,
    denoise,
    finished::{shows_finished, with_finished},
    merge::merge,
    metadata,
};
pub use resume::{
    failure::{FrameError, FrameFailure, OnFailure},
    fingerprint::{Fingerprint, InputHash},
    stale::{Stale, StaleReason, Survey},
};
pub use run::run;
pub use scenes::Scenes;
pub use summary::{SceneFigures, Summary};
