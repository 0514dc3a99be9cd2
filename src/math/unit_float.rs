//! Numbers from 0 to 1 as floats of 16 bits.

/// The offset of all numbers, which makes the smallest ones evenly spaced, down to 0: 2^-31.
const OFFSET: f32 = f32::from_bits(96 << 23);

/// The bits of a float's mantissa that are dropped.
const DROPPED: u32 = 12;

/// A number from 0 to 1. The relative error is at most 2^-12 above 1e-6. 0 and 1 are exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct UnitFloat(u16);

impl UnitFloat {
    /// The nearest of these numbers to `x`; 0 where it is no number.
    #[inline]
    pub fn new(x: f32) -> Self {
        // `max` is 0 for NaN, `clamp` is not.
        let inside = x.max(0.0).clamp(0.0, 1.0);
        let bits = (inside + OFFSET).to_bits() - OFFSET.to_bits();
        Self(((bits + (1 << (DROPPED - 1))) >> DROPPED) as u16)
    }

    #[inline(always)]
    pub fn get(self) -> f32 {
        f32::from_bits((u32::from(self.0) << DROPPED) + OFFSET.to_bits()) - OFFSET
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_eleven_bits_and_what_is_outside_is_clamped() {
        for bits in (1e-6_f32.to_bits()..1.0_f32.to_bits()).step_by(997) {
            let x = f32::from_bits(bits);
            let error = (UnitFloat::new(x).get() / x - 1.0).abs();
            assert!(error <= 1.01 / 4096.0, "{x}: {error}");
        }
        for (x, expected) in [
            (0.0, 0.0),
            (1.0, 1.0),
            (0.5, 0.5),
            (-3.0, 0.0),
            (7.0, 1.0),
            (f32::NAN, 0.0),
        ] {
            assert_eq!(UnitFloat::new(x).get(), expected, "{x}");
        }
        for code in 0..=UnitFloat::new(1.0).0 {
            assert_eq!(UnitFloat::new(UnitFloat(code).get()).0, code);
        }
    }
}
