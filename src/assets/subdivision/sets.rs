//! Disjoint sets of numbers.

/// Numbers from 0 in disjoint sets.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    /// Returns the numbers below `count`, each in a set of its own.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The least number of the set that `number` is in.
    pub fn first(&mut self, number: u32) -> u32 {
        let mut at = number as usize;
        while self.0[at] as usize != at {
            self.0[at] = self.0[self.0[at] as usize];
            at = self.0[at] as usize;
        }
        at as u32
    }

    /// Unites the sets of two numbers.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
