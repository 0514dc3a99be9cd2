//! Frames with fewer samples because of a time limit.

use crate::{
    batch::Plan,
    film::Film,
    output::{Attribute, FileFacts, FrameMetadata},
};

/// The attribute of such files: the limit, in seconds.
const TIME_LIMIT: &str = "batch-render/time-limit";

/// Records the number of samples in the metadata of a frame, if it does not have all.
pub(in crate::batch) fn mark(metadata: &mut FrameMetadata, plan: &Plan, film: &Film) {
    let budget = plan.picture.settings.samples;
    if let Some(limit) = budget.time.filter(|_| film.samples < budget.max) {
        metadata.samples = film.samples;
        metadata
            .attributes
            .push(Attribute::new(TIME_LIMIT, limit.as_secs_f64()));
    }
}

/// Whether a file has fewer samples because of a shorter time limit than that of `plan`.
pub(in crate::batch) fn is_too_short(facts: &FileFacts, plan: &Plan) -> bool {
    let limit = facts.attribute(TIME_LIMIT).map(ToString::to_string);
    let limit = limit.map(|text| text.parse::<f64>().unwrap_or(0.0));
    let own = plan.picture.settings.samples.time.map(|own| own.as_secs_f64());
    limit.is_some_and(|limit| own.is_none_or(|own| own > limit))
}
