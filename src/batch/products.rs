//! The files that a job makes beside its pictures, and the list of all files that it writes.

pub mod coco;
mod colmap;
pub mod denoise;
pub(super) mod denoised;
pub(super) mod draws;
mod films;
pub(super) mod finished;
mod ids;
pub(super) mod labels;
pub(super) mod merge;
pub mod metadata;
pub(super) mod sidecars;
pub(super) mod targets;
mod transforms;
