//! Pictures of both eyes: each frame is rendered twice, and the films are joined before they are written.
//!
//! The halves of a picture have the bits that the pictures of the eyes have by themselves.

use super::request::Request;
use crate::{batch::metadata::Sidecar, error::Error};

/// Refuses what works on the picture of one camera.
pub(in crate::batch) fn check(request: &Request) -> Result<(), Error> {
    let Some(second) = request.second_eye else {
        return Ok(());
    };
    let policy = &request.policy;
    let has_cameras = request.metadata.iter().any(|sidecar| *sidecar != Sidecar::Ids);
    let refused = [
        ("--crop", request.crop.is_some()),
        ("--overscan", request.overscan > 0),
        ("--denoise", request.denoise.is_some()),
        ("--time-limit", request.time_limit.is_some()),
        ("--checkpoint", policy.checkpoint.is_some()),
        ("--keep-sums", policy.keep_sums),
        ("--sample-range", request.sample_ranges.is_some()),
        ("--metadata transforms, colmap and coco", has_cameras),
    ];
    match refused.into_iter().find(|(_, is_there)| *is_there) {
        None => Ok(()),
        Some((flag, _)) => Err(Error::Usage(format!(
            "--stereo with layout={}: {flag} can only work on the picture of one eye: render each eye into files of its own (-o '{{eye}}/####.exr')",
            second.layout
        ))),
    }
}
