//! The pictures of frames that were there before a job.

use super::films;
use crate::{
    batch::{Plan, PlannedFrame},
    output::{Contents, Coverage, Exr, ExrFile, Format as _, FrameImage, Shown},
};

/// Whether the pictures of frames that were there before a job can be shown: by files for displays, or as [`with_finished`] does.
pub fn shows_finished(plan: &Plan) -> bool {
    let files = plan.all_frames().first().map(|frame| plan.final_files(frame));
    files.iter().flatten().any(|file| match file.format.contents() {
        Contents::Picture => true,
        Contents::Data => file.format.name() == Exr.name() && shows_exr(plan),
        Contents::Pass => false,
    })
}

/// Whether the light of EXR files is the picture of the job, at an exposure that is known without its scene.
fn shows_exr(plan: &Plan) -> bool {
    plan.picture.shown == Shown::All && plan.picture.metering_camera.is_none()
}

/// Hands the picture of a frame's EXR file to `show`, as the job's files for displays show it. `None` where there is none, where
/// the job shows a pass, or where the exposure is that of a scene that is not metered.
pub fn with_finished<T>(plan: &Plan, frame: &PlannedFrame, show: impl FnOnce(&FrameImage<'_>) -> T) -> Option<T> {
    if !shows_exr(plan) {
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
        shown: plan.picture.shown,
        coverage: Coverage::Partial,
        metadata: &metadata,
    }))
}
