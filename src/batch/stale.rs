//! Stale frames: those whose files are not what the job would write.

use std::{fmt, path::PathBuf};

use rayon::prelude::*;

use super::{
    Plan, PlannedFrame,
    fingerprint::{FINGERPRINT, Fingerprint, InputHash},
    time_limit,
};
use crate::output::Value;

/// Why a frame is rendered though it was to be left out if possible.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stale {
    pub path: PathBuf,
    pub reason: StaleReason,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StaleReason {
    /// There is no such file.
    Missing,
    /// It is cut off, altered or no picture at all.
    Damaged,
    /// It has no fingerprint: another program, or an older version of this one, wrote it.
    Foreign,
    /// A shorter limit of time than this job's has left it with fewer samples.
    CutShort,
    /// It was rendered from other inputs, by another camera or with other settings.
    Outdated,
}

impl fmt::Display for StaleReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Missing => "is missing",
            Self::Damaged => "is incomplete or altered",
            Self::Foreign => "was not written by this version of batch-render",
            Self::CutShort => "was cut short by a shorter time limit",
            Self::Outdated => "was rendered from other inputs or with other settings",
        })
    }
}

impl fmt::Display for Stale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.path.display(), self.reason)
    }
}

impl PlannedFrame {
    /// The first of the frame's files that is not what the job would write; `None` where all are.
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

/// The frames of a plan that need not be rendered, as a job finds them before its first one.
#[derive(Clone, Debug)]
pub struct Survey {
    pub inputs: InputHash,
    /// The first stale file of each frame, if any.
    pub stale: Vec<Option<Stale>>,
}

impl Survey {
    /// Looks at the files of all frames, on the threads of the current rayon pool.
    pub fn new(plan: &Plan, inputs: InputHash) -> Self {
        let stale = plan.frames.par_iter().map(|frame| frame.stale(plan, inputs));
        Self {
            inputs,
            stale: stale.collect(),
        }
    }

    /// The survey of a job that renders all frames, whatever is there.
    pub fn of_nothing(inputs: InputHash) -> Self {
        Self {
            inputs,
            stale: Vec::new(),
        }
    }

    /// Whether frame `index` of the plan is there as the job would write it.
    pub fn has(&self, index: usize) -> bool {
        self.stale.get(index).is_some_and(Option::is_none)
    }
}
