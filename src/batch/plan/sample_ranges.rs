//! Ranges of samples: what they go with.

use crate::{batch::Request, error::Error, render::SampleRanges};

/// Checks that so many samples can be divided into these ranges.
pub(super) fn check(ranges: SampleRanges, samples: u32, is_adaptive: bool, request: &Request) -> Result<(), Error> {
    let (policy, is_one) = (&request.policy, ranges.only.is_some());
    let others = [
        (is_adaptive, "adaptive sampling: give --noise-threshold 0"),
        (request.time_limit.is_some(), "--time-limit"),
        (policy.keep_sums, "--keep-sums: each range keeps its own"),
        (
            is_one && request.denoise.is_some(),
            "--denoise: give it to the job of all ranges",
        ),
        (
            !is_one && policy.checkpoint.is_some(),
            "--checkpoint: give it to the jobs of single ranges",
        ),
    ];
    let message = match others.into_iter().find(|(is_given, _)| *is_given) {
        Some((_, other)) => format!("--sample-range does not go with {other}"),
        None if ranges.count > samples => {
            let count = ranges.count;
            format!("--sample-range {ranges}: {samples} samples cannot be divided into {count} ranges")
        }
        None => return Ok(()),
    };
    Err(Error::Usage(message))
}
