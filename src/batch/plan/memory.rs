//! The memory of the frames of a job.

use crate::{
    assets::{MemoryBudget, MemoryKind},
    batch::PicturePlan,
    describe::SceneDesc,
    error::Error,
    render,
};

/// The number of frames in memory at once: one renders, one waits, one is written, encoded beside its pixels.
const FRAMES_IN_MEMORY: u64 = 4;

/// Why the sums of all tiles of a frame are kept until it is finished.
#[derive(Clone, Copy)]
pub(in crate::batch) struct KeptSums {
    /// The scene moves: a frame is rendered moment by moment.
    pub moves: bool,
    /// They are copied for checkpoints, or kept when the frame is finished.
    pub copies: bool,
}

/// Reserves the memory of the frames that exist at the same time.
pub(in crate::batch) fn take(
    desc: &SceneDesc,
    picture: &PicturePlan,
    kept: KeptSums,
    memory: &MemoryBudget,
) -> Result<(), Error> {
    let settings = &picture.settings;
    let layout = settings
        .film_layout(render::picture_of(picture.integrator.as_dyn()), &desc.light_groups())
        .map_err(|unknown| Error::Usage(unknown.to_string()))?;
    let pixels = (settings.window.area() as u64).saturating_mul(picture.eyes());
    let frame = pixels.saturating_mul(layout.bytes_per_pixel());
    // They are kept as well if a frame has several rounds.
    let copies = u64::from(kept.moves || settings.samples.time.is_some()) + 2 * u64::from(kept.copies);
    let mut accumulators = settings.accumulator_layout(&layout);
    if desc.has_catchers() {
        accumulators = accumulators.with_catchers();
    }
    let sums = settings
        .rendered_pixels()
        .saturating_mul(accumulators.bytes_per_pixel());
    let bytes = frame
        // The films of two eyes become one.
        .saturating_mul(FRAMES_IN_MEMORY + picture.eyes() - 1)
        .saturating_add(sums.saturating_mul(copies));
    let [width, height] = settings.resolution;
    memory
        .take(MemoryKind::Frames, bytes)
        .map_err(|cause| Error::Memory { width, height, cause })
}
