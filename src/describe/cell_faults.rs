//! Problems of cells of tables of values.

use super::{Diagnostics, Error, Overrides, SceneDesc};
use crate::value::{OVERRIDES, Problem};

/// The most problems that are told.
const MOST_PROBLEMS: usize = 20;

/// Problems of cells so far, each with its origin.
pub(super) struct Faults<'d> {
    desc: &'d SceneDesc,
    overrides: Overrides,
    problems: Vec<Problem>,
}

impl<'d> Faults<'d> {
    pub fn new(desc: &'d SceneDesc) -> Self {
        Self {
            desc,
            overrides: desc.source.overrides.clone(),
            problems: Vec::new(),
        }
    }

    pub fn add(&mut self, origin: String, problem: Problem) {
        let start = OVERRIDES + self.overrides.paths().count();
        self.overrides.set_cell(&origin, "");
        self.problems.push(Problem {
            span: Some(start..start + 1),
            ..problem
        });
    }

    /// Whether there are as many as are told.
    pub fn are_many(&self) -> bool {
        self.problems.len() >= MOST_PROBLEMS
    }

    /// # Errors
    /// There are problems.
    pub fn check(self) -> Result<(), Error> {
        let source = self.desc.source.clone().with(self.overrides);
        Diagnostics::new(&source, self.problems).map_or(Ok(()), |found| Err(Error::Invalid(found)))
    }
}
