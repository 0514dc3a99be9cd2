//! The medium inside of a transparent body.

use crate::math::{Rgb, WorkingSpace, exponential};

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

/// The absorption coefficient, in m^-1, that colours white light in the same way in a working space: by the light that is left
/// where the strongest channel has lost all but 1/e of it.
pub fn converted_absorption(absorption: Rgb, space: WorkingSpace) -> Rgb {
    let strongest = absorption.max_component();
    if strongest <= 0.0 || !strongest.is_finite() {
        return absorption;
    }
    let distance = strongest.recip();
    let left = absorption.map(|a| exponential::exp(-a * distance));
    space
        .from_rec709(left)
        .map(|left| (-exponential::ln(left) / distance).max(0.0))
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
