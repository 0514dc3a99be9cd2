//! A per-thread policy for tracing shadow rays: earlier batches show which methods pay off.
//!
//! The policy affects speed only, never the hits.

use super::super::kernels::ray_stream::StreamReport;

/// Rays of a batch that are traced without packets to measure their cost, if the others are
/// candidates for packets. The cost varies by a factor of two between parts of an image.
pub const PROBE_RAYS: usize = 64;

/// The number of rays for which a measured cost is valid.
const PROBE_INTERVAL: usize = PROBE_RAYS * PROBE_RAYS;

/// The largest number of batches that skip a method after it did not pay off.
const MAX_BATCHES_WITHOUT: u32 = 16;

/// The policy for shadow rays.
pub struct OcclusionPolicy {
    /// The backoff of packets.
    pub packets: Backoff,
    /// The cost of a ray that is traced without a packet, in halves of a node test.
    single_cost: u64,
    /// The number of candidates for packets since the last probe; the maximum before the first
    /// probe.
    since_probe: usize,
}

impl OcclusionPolicy {
    pub const fn new() -> Self {
        Self {
            packets: Backoff::new(),
            single_cost: 40,
            since_probe: usize::MAX,
        }
    }

    pub fn single_cost(&self) -> u64 {
        self.single_cost
    }

    /// Returns the rays of a batch of `count` candidates for packets that are to be traced without
    /// packets first, or `None` if their cost is known.
    pub fn probe(&mut self, count: usize) -> Option<[u32; PROBE_RAYS]> {
        self.since_probe = self.since_probe.saturating_add(count);
        let is_due = self.since_probe >= PROBE_INTERVAL && count >= PROBE_RAYS;
        is_due.then(|| std::array::from_fn(|k| (k * count / PROBE_RAYS) as u32))
    }

    /// Records the cost that the probe rays had.
    pub fn record_probe(&mut self, report: StreamReport) {
        self.single_cost = report.cost / PROBE_RAYS as u64;
        self.since_probe = 0;
    }
}

/// Decides whether a method is tried. After each failure it is skipped for more batches, up to
/// [`MAX_BATCHES_WITHOUT`].
pub struct Backoff {
    without: u32,
    next: u32,
}

impl Backoff {
    const fn new() -> Self {
        Self { without: 0, next: 0 }
    }

    /// Returns whether to try the method on this batch.
    pub fn should_try(&mut self) -> bool {
        let tries = self.without == 0;
        self.without = self.without.saturating_sub(1);
        tries
    }

    /// Records whether the method paid off on a batch.
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
        policy.record_probe(StreamReport { cost: 64 * 50 });
        assert_eq!(policy.single_cost(), 50);
        assert!(policy.probe(PROBE_INTERVAL - 1).is_none());
        assert!(policy.probe(PROBE_RAYS).is_some());
    }
}
