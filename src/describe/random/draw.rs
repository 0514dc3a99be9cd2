//! Random numbers by their addresses: the name of a value and the number of a frame.

use crate::{assets::ContentHash, math::hash::pcg4d};

/// The key of a value that is drawn. Values of other names have independent keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawKey([u32; 2]);

impl DrawKey {
    /// The key of the value `name` in a scene of this name.
    pub fn new(seed: u64, scene: &str, name: &str) -> Self {
        // No name has the character 0 in it.
        let text = format!("{seed}\0{scene}\0{name}");
        let hash = ContentHash::of(text.as_bytes());
        let word = |at: usize| {
            let bytes = hash.as_bytes();
            u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
        };
        Self([word(0), word(4)])
    }

    /// The random numbers of a frame.
    pub fn numbers(self, frame: i64) -> Numbers {
        Numbers {
            key: self.0,
            frame: frame as u32,
            next: 0,
        }
    }
}

/// The random numbers of a value at a frame, in a row.
#[derive(Clone, Debug)]
pub struct Numbers {
    key: [u32; 2],
    frame: u32,
    next: u32,
}

impl Numbers {
    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        let [a, b] = self.key;
        let [low, high, ..] = pcg4d([a, b, self.frame, self.next]);
        self.next += 1;
        u64::from(low) | u64::from(high) << 32
    }

    /// A uniform number in `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// A uniform whole number from `least` to `most`. A number is off its probability by less than the count of them / 2^64.
    pub fn whole(&mut self, [least, most]: [i64; 2]) -> i64 {
        let count = (i128::from(most) - i128::from(least) + 1) as u128;
        let step = (u128::from(self.bits()) * count) >> 64;
        (i128::from(least) + step as i128) as i64
    }
}
