//! The memory that a job may take, by kind.

use std::{
    fmt,
    sync::{
        Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
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
    limit: AtomicU64,
    used: Mutex<Used>,
    /// Notified when a reservation ends.
    ended: Condvar,
}

/// The memory that is in use.
#[derive(Clone, Copy, Debug, Default)]
struct Used {
    /// In bytes, by kind.
    taken: [u64; KINDS],
    /// The number of reservations, whose bytes are among those that are taken.
    reservations: usize,
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
            limit: AtomicU64::new(limit.unwrap_or(u64::MAX)),
            used: Mutex::default(),
            ended: Condvar::new(),
        }
    }

    /// Changes the limit to `bytes`. What is taken already stays so.
    pub fn set_limit(&self, bytes: u64) {
        self.limit.store(bytes, Ordering::Relaxed);
    }

    fn used(&self) -> MutexGuard<'_, Used> {
        self.used.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The bytes that are taken, by kind.
    pub fn taken(&self) -> [(MemoryKind, u64); KINDS] {
        let taken = self.used().taken;
        MemoryKind::ALL.map(|kind| (kind, taken[kind as usize]))
    }

    /// Reserves `bytes` for the rest of the job. Waits where they fit once a reservation has ended.
    ///
    /// # Errors
    /// They exceed the budget.
    pub fn take(&self, kind: MemoryKind, bytes: u64) -> Result<(), OverBudget> {
        self.wait_for(self.used(), kind, bytes).map(drop)
    }

    /// Reserves `bytes` for a short time. Waits where they fit once another reservation has ended, so that which thread comes first
    /// does not decide whether they do. A thread that has a reservation takes no other memory and waits for no other thread.
    ///
    /// # Errors
    /// They exceed the budget.
    pub fn reserve(&self, kind: MemoryKind, bytes: u64) -> Result<Reservation<'_>, OverBudget> {
        self.wait_for(self.used(), kind, bytes)?.reservations += 1;
        Ok(Reservation {
            budget: self,
            kind,
            bytes,
        })
    }

    /// Takes `bytes` as soon as they fit, if no more than the end of reservations is needed for that.
    fn wait_for<'a>(
        &self,
        mut used: MutexGuard<'a, Used>,
        kind: MemoryKind,
        bytes: u64,
    ) -> Result<MutexGuard<'a, Used>, OverBudget> {
        loop {
            match used.take(kind, bytes, self.limit.load(Ordering::Relaxed)) {
                Err(_) if used.reservations > 0 => {
                    used = self.ended.wait(used).unwrap_or_else(PoisonError::into_inner);
                }
                taken => return taken.map(|()| used),
            }
        }
    }

    /// Gives back all memory of a kind.
    pub fn release(&self, kind: MemoryKind) {
        self.used().taken[kind as usize] = 0;
    }

    /// Checks whether `bytes` fit, for memory that is needed for a short time only. Waits as [`MemoryBudget::take`] does.
    ///
    /// # Errors
    /// They exceed the budget.
    pub fn check(&self, kind: MemoryKind, bytes: u64) -> Result<(), OverBudget> {
        let mut used = self.wait_for(self.used(), kind, bytes)?;
        used.taken[kind as usize] -= bytes;
        Ok(())
    }
}

impl Used {
    fn take(&mut self, kind: MemoryKind, bytes: u64, limit: u64) -> Result<(), OverBudget> {
        let taken = self.taken;
        let sum = taken.iter().fold(bytes, |sum, of_kind| sum.saturating_add(*of_kind));
        if sum > limit {
            return Err(OverBudget {
                kind,
                bytes,
                taken,
                limit,
            });
        }
        self.taken[kind as usize] += bytes;
        Ok(())
    }
}

/// Memory that is reserved for a short time: until this is dropped.
#[derive(Debug)]
pub struct Reservation<'a> {
    budget: &'a MemoryBudget,
    kind: MemoryKind,
    bytes: u64,
}

impl Drop for Reservation<'_> {
    fn drop(&mut self) {
        let mut used = self.budget.used();
        used.taken[self.kind as usize] = used.taken[self.kind as usize].saturating_sub(self.bytes);
        used.reservations -= 1;
        self.budget.ended.notify_all();
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
        let bytes = |bytes| match self.limit < 1 << 20 {
            true => format!("{} KiB", u64::div_ceil(bytes, 1 << 10)),
            false => mebibytes(bytes),
        };
        write!(f, "{} need {} of memory", self.kind.name(), bytes(self.bytes))?;
        for kind in MemoryKind::ALL {
            let taken = self.taken[kind as usize];
            if taken > 0 {
                write!(f, ", {} have taken {}", kind.name(), bytes(taken))?;
            }
        }
        write!(f, ", and {} are allowed (--max-memory)", bytes(self.limit))
    }
}

impl std::error::Error for OverBudget {}

fn mebibytes(bytes: u64) -> String {
    format!("{} MiB", bytes.div_ceil(1 << 20))
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;

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

    #[test]
    fn a_new_limit_holds_for_what_is_taken_after_it() {
        let budget = MemoryBudget::new(Some(4 << 20));
        budget.take(MemoryKind::Images, 4 << 20).expect("allowed");
        assert!(budget.take(MemoryKind::Trees, 1).is_err());
        budget.set_limit(5 << 20);
        budget.take(MemoryKind::Trees, 1 << 20).expect("allowed now");
        budget.set_limit(1 << 20);
        let refused = budget.take(MemoryKind::Trees, 1).expect_err("too much");
        assert_eq!(refused.limit, 1 << 20);
    }

    #[test]
    fn reservations_of_several_threads_never_exceed_the_limit_and_all_get_theirs() {
        let budget = MemoryBudget::new(Some(10 << 20));
        let alone = Mutex::new(());
        let threads = Barrier::new(4);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    threads.wait();
                    for _ in 0..50 {
                        let reserved = budget.reserve(MemoryKind::Models, 6 << 20).expect("it fits alone");
                        drop(alone.try_lock().expect("two of them do not fit"));
                        drop(reserved);
                    }
                    budget.take(MemoryKind::Models, 1 << 20).expect("it fits afterwards");
                });
            }
        });
        assert_eq!(budget.used().taken[MemoryKind::Models as usize], 4 << 20);
        let refused = budget.reserve(MemoryKind::Models, 7 << 20).expect_err("too much");
        assert_eq!((refused.bytes, budget.used().reservations), (7 << 20, 0));
    }
}
