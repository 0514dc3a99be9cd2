//! The memory that a job may take, by kind.

use std::{
    fmt,
    sync::{Mutex, PoisonError},
};

use crate::kind::named;

named! {
    /// The purpose of memory.
    pub enum MemoryKind: "memory" {
        /// Frames that are rendered, wait, or are written.
        Frames = "frames",
        /// Decoded images.
        Images = "images",
        /// The arrays of models, until the scene has its own.
        Models = "models",
        /// The arrays of a scene: shapes, triangles, instances.
        Shapes = "shapes",
        /// The acceleration structure, with what its construction takes.
        Trees = "trees",
    }
}

/// The memory limit of a job, and its use. Every large array is registered here before it is allocated.
#[derive(Debug)]
pub struct MemoryBudget {
    /// In bytes.
    limit: u64,
    /// In bytes, by kind.
    taken: Mutex<[u64; KINDS]>,
}

impl Default for MemoryBudget {
    fn default() -> Self {
        Self::new(None)
    }
}

/// The number of kinds.
const KINDS: usize = MemoryKind::ALL.len();

impl MemoryBudget {
    /// A budget of `limit` bytes; `None` is no limit.
    pub fn new(limit: Option<u64>) -> Self {
        Self {
            limit: limit.unwrap_or(u64::MAX),
            taken: Mutex::default(),
        }
    }

    /// The bytes that are taken, by kind.
    pub fn taken(&self) -> [(MemoryKind, u64); KINDS] {
        let taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        MemoryKind::ALL.map(|kind| (kind, taken[kind as usize]))
    }

    /// Reserves `bytes` for the rest of the job.
    ///
    /// # Errors
    /// They exceed the budget.
    pub fn take(&self, kind: MemoryKind, bytes: u64) -> Result<(), OverBudget> {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let sum = taken.iter().fold(bytes, |sum, of_kind| sum.saturating_add(*of_kind));
        if sum > self.limit {
            return Err(OverBudget {
                kind,
                bytes,
                taken: *taken,
                limit: self.limit,
            });
        }
        taken[kind as usize] += bytes;
        Ok(())
    }

    /// Gives back all memory of a kind.
    pub fn release(&self, kind: MemoryKind) {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)[kind as usize] = 0;
    }

    /// Checks whether `bytes` fit, for memory that is needed for a short time only.
    ///
    /// # Errors
    /// They exceed the budget.
    pub fn check(&self, kind: MemoryKind, bytes: u64) -> Result<(), OverBudget> {
        let taken = *self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let all = Self {
            limit: self.limit,
            taken: Mutex::new(taken),
        };
        all.take(kind, bytes)
    }
}

/// A request exceeds the budget. All numbers are in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OverBudget {
    kind: MemoryKind,
    bytes: u64,
    /// By kind.
    taken: [u64; KINDS],
    limit: u64,
}

impl fmt::Display for OverBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} need {} of memory", self.kind.name(), mebibytes(self.bytes))?;
        for kind in MemoryKind::ALL {
            let taken = self.taken[kind as usize];
            if taken > 0 {
                write!(f, ", {} have taken {}", kind.name(), mebibytes(taken))?;
            }
        }
        write!(f, ", and {} are allowed (--max-memory)", mebibytes(self.limit))
    }
}

impl std::error::Error for OverBudget {}

fn mebibytes(bytes: u64) -> String {
    format!("{} MiB", bytes.div_ceil(1 << 20))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_of_all_kinds_stays_below_the_limit() {
        let budget = MemoryBudget::new(Some(10 << 20));
        budget.take(MemoryKind::Frames, 4 << 20).expect("allowed");
        budget.take(MemoryKind::Images, 5 << 20).expect("allowed");
        budget.check(MemoryKind::Models, 1 << 20).expect("allowed");
        let refused = budget.take(MemoryKind::Images, 2 << 20).expect_err("too much");
        assert_eq!(
            refused.to_string(),
            "images need 2 MiB of memory, frames have taken 4 MiB, images have taken 5 MiB, and 10 MiB are allowed \
             (--max-memory)"
        );
        // Refused and checked requests are not counted.
        budget.take(MemoryKind::Models, 1 << 20).expect("allowed");
        assert!(budget.check(MemoryKind::Models, 1).is_err());
        budget.release(MemoryKind::Models);
        budget
            .take(MemoryKind::Trees, 1 << 20)
            .expect("models have given theirs back");
        MemoryBudget::default()
            .take(MemoryKind::Frames, u64::MAX)
            .expect("no limit");
    }
}
