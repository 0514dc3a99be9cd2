//! What is not tried again for a while where it did not pay.

/// Whether something is tried: where it did not pay, the next batches do without, up to 16 of them.
#[derive(Default)]
pub struct Doubt {
    without: u32,
    next: u32,
}

impl Doubt {
    /// Whether to try it with this batch.
    pub fn tries(&mut self) -> bool {
        let tries = self.without == 0;
        self.without = self.without.saturating_sub(1);
        tries
    }

    /// After a batch with it.
    pub fn learn(&mut self, pays: bool) {
        if pays {
            self.next = 0;
        } else {
            self.without = self.next;
            self.next = (2 * self.next + 1).min(16);
        }
    }
}
