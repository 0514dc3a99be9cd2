//! The medium inside of a transparent body.

use crate::math::{Rgb, exponential};

/// The smallest transmittance of a colour's channel: nothing absorbs everything.
const MIN_TRANSMITTANCE: f32 = 1e-6;

/// The medium inside of a transparent body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// The absorption coefficient, in m^-1.
    pub absorption: Rgb,
    /// Index of refraction.
    pub ior: f32,
    /// The rank of the body: of overlapping ones the highest fills the place.
    pub priority: i32,
}

/// The absorption (m^-1) of a medium that turns white light into `color` over `distance` (m).
pub fn absorption(color: Rgb, distance: f32) -> Rgb {
    color.map(|c| -exponential::ln(c.clamp(MIN_TRANSMITTANCE, 1.0)) / distance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn over_its_distance_a_medium_takes_on_its_color() {
        let color = Rgb::new(1.0, 0.5, 0.1);
        let absorption = absorption(color, 3.0);
        let left = absorption.map(|a| exponential::exp(-a * 3.0));
        assert!((left - color).map(f32::abs).max_component() < 1e-6);
        assert_eq!(absorption.r, 0.0);
    }
}
