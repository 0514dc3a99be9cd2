//! The pictures of frames that were there before a job.

use super::films;
use crate::{
    batch::{Plan, PlannedFrame},
    output::{Coverage, Exr, ExrFile, Format as _, FrameImage, Shown},
};

/// Hands the picture of a frame's EXR file to `show`, as the job's files for displays show it. `None` where there is none, where the
/// job shows a pass, or where the exposure is that of a scene that is not metered.
pub fn with_finished<T>(plan: &Plan, frame: &PlannedFrame, show: impl FnOnce(&FrameImage<'_>) -> T) -> Option<T> {
    let picture = &plan.picture;
    if picture.shown != Shown::All || picture.metering_camera.is_some() {
        return None;
    }
    let files = plan.final_files(frame);
    let file = files.iter().find(|file| file.format.name() == Exr.name())?;
    let file = ExrFile::read(&file.path).ok()?;
    file.planes().find(|plane| plane.name == "R")?;
    let film = films::picture(&file);
    let metadata = plan.metadata(frame.number);
    Some(show(&FrameImage {
        film: &film,
        shown: picture.shown,
        coverage: Coverage::Partial,
        metadata: &metadata,
    }))
}
