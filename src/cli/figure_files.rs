//! The files of figures: written whole, read, and joined with those of other jobs that write the same file.

use std::{collections::HashSet, fmt, fs, path::Path};

use batch_render::{
    batch::{Existing, Plan},
    output::{OutputError, atomic},
    warnings::{WarningKind, Warnings},
};
use serde::de::DeserializeOwned;

use super::figures::Report;

/// The page of a report, and its figures in a form to which other jobs of the sequence add theirs.
pub const PAGE: &str = "index.html";
pub const ALBUM: &str = "figures.json";

/// The figures of others that a job keeps.
#[derive(Clone)]
pub struct Joining {
    settings: String,
    /// The frames that the job goes on with; `None` if it is a part of a sequence, and keeps those of other parts.
    own: Option<HashSet<i32>>,
    warnings: Warnings,
}

impl Joining {
    /// `None` for a job that keeps no figures but its own: it renders all frames of a sequence, whether their files exist or not.
    pub fn new(plan: &Plan, settings: &str) -> Option<Self> {
        let joins = plan.is_chunk || plan.policy.existing == Existing::Skip || !plan.renders();
        let own = || plan.frames.iter().map(|frame| frame.number).collect();
        joins.then(|| Self {
            settings: settings.to_owned(),
            own: (!plan.is_chunk).then(own),
            warnings: plan.warnings.clone(),
        })
    }

    /// Removes the frames that the job does not keep from `report`, which was read from the file at `path`. Returns `false` if the
    /// report is of other inputs or settings, so that the job keeps none of it.
    pub fn select(&self, report: &mut Report, path: &Path) -> bool {
        if report.settings != self.settings {
            if self.own.is_none() {
                self.lost(&"they are of other inputs or settings", path);
            }
            return false;
        }
        if let Some(own) = &self.own {
            report.frames.retain(|frame| own.contains(&frame.frame));
        }
        true
    }

    /// Reads the file at `path`, if there is one.
    pub fn read<T: DeserializeOwned>(&self, path: &Path) -> Option<T> {
        read(path).map_err(|cause| self.lost(&cause, path)).ok().flatten()
    }

    fn lost(&self, cause: &dyn fmt::Display, path: &Path) {
        let path = path.display();
        let text = format!("the figures of other jobs are lost, {cause}: {path}");
        self.warnings.add_live(WarningKind::LOST_FRAMES, path, text);
    }
}

/// Reads the figures in the file at `path`; `None` if there is no such file.
pub fn read<T: DeserializeOwned>(path: &Path) -> serde_json::Result<Option<T>> {
    // Pipes and devices block or never end.
    let text = path.is_file().then(|| fs::read(path).ok()).flatten();
    text.map(|text| serde_json::from_slice(&text)).transpose()
}

/// Writes a file in an existing folder.
pub fn write_text(path: &Path, text: &str) -> Result<(), OutputError> {
    atomic::write(path, |out| Ok(out.write_all(text.as_bytes())?))
}
