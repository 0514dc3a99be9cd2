//! Every number independent of every other: the baseline.

use super::{Dimension, SampleKey};
use crate::math::{
    Vec2,
    hash::{mix32, pcg4d, unit_f32},
};

/// White noise from a hash of the address.
#[derive(Clone, Copy, Debug)]
pub struct Independent;

impl Independent {
    /// Two numbers in `[0, 1)`.
    pub fn pair(self, key: &SampleKey, dimension: Dimension) -> Vec2 {
        let picture = mix32(key.seed) ^ (key.frame as u32).wrapping_mul(0x9e37_79b9);
        let [a, b, _, _] = pcg4d([key.pixel[0] ^ mix32(picture), key.pixel[1], key.sample, dimension.0]);
        Vec2::new(unit_f32(a), unit_f32(b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(seed: u32, frame: i32, x: u32, sample: u32) -> SampleKey {
        SampleKey {
            seed,
            frame,
            pixel: [x, 3],
            sample,
        }
    }

    #[test]
    fn any_part_of_the_address_changes_the_numbers() {
        let base = Independent.pair(&key(1, 2, 3, 4), Dimension::FILM);
        for other in [key(2, 2, 3, 4), key(1, 3, 3, 4), key(1, 2, 4, 4), key(1, 2, 3, 5)] {
            assert_ne!(Independent.pair(&other, Dimension::FILM), base);
        }
        assert_ne!(Independent.pair(&key(1, 2, 3, 4), Dimension::LENS), base);
    }

    #[test]
    fn numbers_fill_the_unit_square_evenly() {
        let mut cells = [0_u32; 64];
        for sample in 0..64_000 {
            let u = Independent.pair(&key(0, 0, 0, sample), Dimension::FILM);
            cells[(u.x * 8.0) as usize * 8 + (u.y * 8.0) as usize] += 1;
        }
        // Chi-square with 63 degrees of freedom: 99.99 % lie below 115.
        let chi2: f64 = cells.iter().map(|&n| (f64::from(n) - 1000.0).powi(2) / 1000.0).sum();
        assert!(chi2 < 115.0, "{chi2}");
    }
}
