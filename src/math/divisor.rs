//! Whole numbers, divided often by the same one.

/// A number from 1 to 2^20 that others are divided by with a multiplication.
#[derive(Clone, Copy, Debug)]
pub struct Divisor {
    by: u32,
    reciprocal: u64,
}

/// The largest divisor and the largest dividend.
const MAX: u32 = 1 << 20;

impl Divisor {
    pub fn new(by: u32) -> Self {
        debug_assert!((1..=MAX).contains(&by));
        Self {
            by,
            reciprocal: (1_u64 << 40).div_ceil(u64::from(by)),
        }
    }

    /// The quotient and the remainder of a number up to 2^20.
    ///
    /// The reciprocal is too large by less than 1, so the quotient by less than 2^20 / 2^40 before
    /// it is rounded down; it is a multiple of 1 / `by` above or on a whole number.
    #[inline(always)]
    pub fn divide(self, n: u32) -> (u32, u32) {
        debug_assert!(n <= MAX);
        let quotient = ((u64::from(n) * self.reciprocal) >> 40) as u32;
        (quotient, n - quotient * self.by)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_divisor_divides_as_division_does() {
        let near = |n: u32| [n.saturating_sub(1).max(1), n, n + 1].map(|n| n.min(MAX));
        for by in [1, 3, 7, 10, 31, 64, 1000, 16_384, 99_991, MAX]
            .into_iter()
            .flat_map(near)
        {
            let divisor = Divisor::new(by);
            for multiple in (0..MAX / by).step_by((MAX / by / 1000).max(1) as usize) {
                for n in near(multiple * by) {
                    assert_eq!(divisor.divide(n), (n / by, n % by));
                }
            }
        }
    }
}
