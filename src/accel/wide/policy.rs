//! What the batches that a thread has traced tell about the next one: which ways of tracing shadow rays pay.
//!
//! Hits do not depend on it, only time does.

use super::super::kernels::ray_stream::StreamReport;

/// Rays that are traced by themselves to know what those around them cost, where these might go in packets. What that is differs
/// from one part of a picture to another by a factor of two.
pub const PROBE_RAYS: usize = 64;

/// For how many rays that holds.
const PROBE_INTERVAL: usize = PROBE_RAYS * PROBE_RAYS;

/// The most batches that go without what did not pay.
const MAX_BATCHES_WITHOUT: u32 = 16;

/// What is known of shadow rays.
pub struct OcclusionPolicy {
    /// Of packets.
    pub packets: Backoff,
    /// Of entry points below the root.
    pub entry_points: Backoff,
    /// What a ray costs by itself, in halves of a node's test.
    single_cost: u64,
    /// How many rays might have gone in packets since that was found out; before the first, as many as there can be.
    since_probe: usize,
}

impl OcclusionPolicy {
    pub const fn new() -> Self {
        Self {
            packets: Backoff::new(),
            entry_points: Backoff::new(),
            single_cost: 40,
            since_probe: usize::MAX,
        }
    }

    pub fn single_cost(&self) -> u64 {
        self.single_cost
    }

    /// The rays of a batch of `count` rays, which may go in packets, to be traced by themselves first; `None` where it is known
    /// well enough what they cost.
    pub fn probe(&mut self, count: usize) -> Option<[u32; PROBE_RAYS]> {
        self.since_probe = self.since_probe.saturating_add(count);
        let is_due = self.since_probe >= PROBE_INTERVAL && count >= PROBE_RAYS;
        is_due.then(|| std::array::from_fn(|k| (k * count / PROBE_RAYS) as u32))
    }

    /// After these were traced.
    pub fn record_probe(&mut self, report: StreamReport) {
        self.single_cost = report.cost / PROBE_RAYS as u64;
        self.since_probe = 0;
    }
}

/// Whether something is tried: where it did not pay, the next batches do without, up to [`MAX_BATCHES_WITHOUT`] of them.
pub struct Backoff {
    without: u32,
    next: u32,
}

impl Backoff {
    const fn new() -> Self {
        Self { without: 0, next: 0 }
    }

    /// Whether to try it with this batch.
    pub fn should_try(&mut self) -> bool {
        let tries = self.without == 0;
        self.without = self.without.saturating_sub(1);
        tries
    }

    /// After a batch with it.
    pub fn record(&mut self, pays: bool) {
        if pays {
            self.next = 0;
        } else {
            self.without = self.next;
            self.next = (2 * self.next + 1).min(MAX_BATCHES_WITHOUT);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_pay_is_tried_less_and_less_until_it_pays() {
        let mut backoff = Backoff::new();
        let mut batches_without = |pays: bool| {
            backoff.record(pays);
            (0..).take_while(|_| !backoff.should_try()).count()
        };
        let without: Vec<usize> = (0..7).map(|_| batches_without(false)).collect();
        assert_eq!(without, [0, 1, 3, 7, 15, 16, 16]);
        assert_eq!(batches_without(true), 0);
        assert_eq!(batches_without(false), 0);
    }

    #[test]
    fn rays_are_probed_at_first_and_after_an_interval() {
        let mut policy = OcclusionPolicy::new();
        assert!(policy.probe(PROBE_RAYS - 1).is_none());
        let some = policy.probe(10 * PROBE_RAYS).expect("the first");
        assert_eq!(some[..3], [0, 10, 20]);
        policy.record_probe(StreamReport {
            cost: 64 * 50,
            entry_points_pay: None,
        });
        assert_eq!(policy.single_cost(), 50);
        assert!(policy.probe(PROBE_INTERVAL - 1).is_none());
        assert!(policy.probe(PROBE_RAYS).is_some());
    }
}
