//! Failed scenes of a command, and eyes of them.

use std::fmt;

use batch_render::error::{Blame, Error};

use super::summary::plural;

/// Some scenes of a command have failed.
#[derive(Debug)]
pub struct ScenesFailed {
    /// The word for one of them.
    noun: &'static str,
    total: usize,
    failed: Vec<String>,
    /// Whether all of them have failed since other jobs write their files.
    pub are_busy: bool,
}

impl ScenesFailed {
    /// No failures yet of so many scenes, or what `noun` says.
    pub fn new(noun: &'static str, total: usize) -> Self {
        Self {
            noun,
            total,
            failed: Vec::new(),
            are_busy: true,
        }
    }

    /// Adds one that has failed.
    pub fn add(&mut self, label: String, error: &anyhow::Error) {
        self.are_busy &= error.downcast_ref::<Error>().map(Error::blame) == Some(Blame::Busy);
        self.failed.push(label);
    }

    /// An error if any has failed.
    pub fn check(self) -> anyhow::Result<()> {
        match self.failed[..] {
            [] => Ok(()),
            _ => Err(anyhow::Error::new(self)),
        }
    }
}

impl fmt::Display for ScenesFailed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (failed, total) = (self.failed.len(), plural(self.total, self.noun));
        let names = self.failed.join(if self.noun == "eye" { "; " } else { ", " });
        write!(f, "{failed} of {total} failed: {names}")
    }
}

impl std::error::Error for ScenesFailed {}
