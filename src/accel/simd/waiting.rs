//! Which rays in flight wait for what.

/// Rays in flight.
pub const SLOTS: usize = 64;

/// Numbers of slots, to which adding needs no branch.
pub struct List {
    slots: [u8; 2 * SLOTS],
    pub len: usize,
}

impl List {
    pub const EMPTY: Self = Self {
        slots: [0; 2 * SLOTS],
        len: 0,
    };

    #[inline(always)]
    pub fn push_if(&mut self, slot: u8, wanted: u32) {
        // A slot is in one list at a time, so there is always room.
        self.slots[self.len % (2 * SLOTS)] = slot;
        self.len += wanted as usize;
    }

    #[inline(always)]
    pub fn get(&self, i: usize) -> u8 {
        self.slots[i % (2 * SLOTS)]
    }
}

/// Rays by what they wait for.
pub struct Waiting {
    pub at_node: List,
    pub at_leaf: List,
    pub done: List,
}

impl Waiting {
    /// Files a slot under what comes next for it.
    #[inline(always)]
    pub fn file(&mut self, slot: u8, next: u32) {
        let leaf = next >> 31;
        let done = (next >> 30) & !leaf & 1;
        self.at_node.push_if(slot, 1 ^ leaf ^ done);
        self.at_leaf.push_if(slot, leaf);
        self.done.push_if(slot, done);
    }
}
