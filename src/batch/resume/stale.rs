//! Stale frames: those whose files are not what the job would write.

use std::{fmt, path::PathBuf};

use serde::Serialize;

use crate::batch::{Plan, PlannedFrame, as_text, plan::time_limit};

use super::fingerprint::{FINGERPRINT, Fingerprint, InputHash};
use crate::{math::parallel, output::Value};

/// Why a frame is rendered again and not skipped.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Stale {
    #[serde(rename = "file", serialize_with = "as_text::path")]
    pub path: PathBuf,
    #[serde(serialize_with = "as_text::text")]
    pub reason: StaleReason,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StaleReason {
    /// The file does not exist.
    Missing,
    /// It is truncated, altered or no picture.
    Damaged,
    /// It is a picture without a fingerprint, such as one that another program wrote.
    Foreign,
    /// It has fewer samples because of a shorter time limit than this job's.
    CutShort,
    /// Its fingerprint is another one: it was rendered from other inputs, by another camera, with other settings or by
    /// another version of this program.
    Outdated,
    /// It was denoised with a frame whose file is none that the job would write.
    Unhelped,
}

impl fmt::Display for StaleReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Missing => "is missing",
            Self::Damaged => "is incomplete or altered",
            Self::Foreign => "was not written by this version of batch-render",
            Self::CutShort => "was cut short by a shorter time limit",
            Self::Outdated => "was rendered from other inputs or with other settings",
            Self::Unhelped => "was denoised with a frame that is rendered again",
        })
    }
}

impl fmt::Display for Stale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.path.display(), self.reason)
    }
}

impl PlannedFrame {
    /// The first file of the frame that is not what the job would write, if any.
    pub fn stale(&self, plan: &Plan, inputs: InputHash) -> Option<Stale> {
        let expected = Value::from(Fingerprint::of_frame(plan, inputs, self).file);
        self.files.iter().find_map(|file| {
            let reason = if !file.path.exists() {
                StaleReason::Missing
            } else {
                match file.format.inspect(&file.path) {
                    None => StaleReason::Damaged,
                    Some(facts) => match facts.attribute(FINGERPRINT) {
                        Some(found) if *found == expected && time_limit::is_too_short(&facts, plan) => {
                            StaleReason::CutShort
                        }
                        Some(found) if *found == expected => return None,
                        Some(_) => StaleReason::Outdated,
                        None => StaleReason::Foreign,
                    },
                }
            };
            Some(Stale {
                path: file.path.clone(),
                reason,
            })
        })
    }
}

/// The state of all files of a plan before rendering.
#[derive(Clone, Debug)]
pub struct Survey {
    pub inputs: InputHash,
    /// The first stale file of each frame, if any; empty if no files were inspected.
    pub stale: Vec<Option<Stale>>,
}

impl Survey {
    /// Inspects the files of these frames, on the threads of the current rayon pool.
    pub fn new(plan: &Plan, frames: &[PlannedFrame], inputs: InputHash) -> Self {
        Self {
            inputs,
            stale: parallel::map(frames, |frame| frame.stale(plan, inputs)),
        }
    }

    /// The survey of a job that renders all frames, regardless of existing files.
    pub fn of_nothing(inputs: InputHash) -> Self {
        Self {
            inputs,
            stale: Vec::new(),
        }
    }

    /// Whether the files of frame `index` of the plan are what the job would write.
    pub fn has(&self, index: usize) -> bool {
        self.stale.get(index).is_some_and(Option::is_none)
    }
}
