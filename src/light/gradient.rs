//! Light from all directions that changes smoothly from below to above.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `up` | number or `[r, g, b]`: the radiance from straight above | W m^-2 sr^-1 | required |
//! | `side` | the same from the horizon | W m^-2 sr^-1 | required |
//! | `down` | the same from straight below | W m^-2 sr^-1 | required |
//!
//! ```toml
//! [background]
//! gradient = { up = 0.9, side = 0.5, down = 0.1 }
//! ```
//!
//! The radiance from a unit direction `w` is `side + (up - side) w.y` above the horizon, and `side + (down - side) (-w.y)` below
//! it. A surface that faces upwards has the irradiance `pi (side + 2 up) / 3`, one that faces sideways
//! `pi side + 2 (up + down - 2 side) / 3`. The gradient is not sampled as a light, because BSDF sampling finds it well.

use serde::Deserialize;

use crate::{
    math::{Rgb, Vec3, WorkingSpace},
    value::RgbFactor,
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GradientDesc {
    pub up: RgbFactor,
    pub side: RgbFactor,
    pub down: RgbFactor,
}

impl GradientDesc {
    /// The gradient in a working space.
    pub fn compile(&self, working_space: WorkingSpace) -> Gradient {
        let [up, side, down] = [self.up, self.side, self.down].map(|color| working_space.from_rec709(color.0));
        Gradient { up, side, down }
    }
}

/// The radiance from above, from the horizon and from below, in W m^-2 sr^-1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient {
    pub up: Rgb,
    pub side: Rgb,
    pub down: Rgb,
}

impl Gradient {
    /// Whether no light comes from anywhere.
    pub fn is_black(&self) -> bool {
        [self.up, self.side, self.down].iter().all(|color| color.is_black())
    }

    /// The radiance from the unit direction `w`, in W m^-2 sr^-1.
    #[inline]
    pub fn radiance(&self, w: Vec3) -> Rgb {
        let end = if w.y < 0.0 { self.down } else { self.up };
        let t = w.y.abs().min(1.0);
        self.side * (1.0 - t) + end * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SKY: Gradient = Gradient {
        up: Rgb::new(0.9, 0.6, 1.0),
        side: Rgb::new(0.5, 0.5, 0.2),
        down: Rgb::new(0.1, 0.0, 0.2),
    };

    /// The irradiance on a surface that faces `n`, by the midpoint rule over the sphere, with equal solid angles.
    fn irradiance(n: Vec3) -> [f64; 3] {
        let (rows, columns) = (400, 400);
        let mut sum = [0.0; 3];
        for i in 0..rows * columns {
            let y = (f64::from(i / columns) + 0.5) / f64::from(rows) * 2.0 - 1.0;
            let phi = (f64::from(i % columns) + 0.5) / f64::from(columns) * std::f64::consts::TAU;
            let r = (1.0 - y * y).sqrt();
            let w = Vec3::new((r * libm::cos(phi)) as f32, y as f32, (r * libm::sin(phi)) as f32);
            let l = SKY.radiance(w);
            for (sum, l) in sum.iter_mut().zip([l.r, l.g, l.b]) {
                *sum += f64::from(l * n.dot(w).max(0.0));
            }
        }
        sum.map(|sum| sum * 2.0 * std::f64::consts::TAU / f64::from(rows * columns))
    }

    #[test]
    fn irradiance_of_a_gradient_equals_its_closed_form() {
        let pi = std::f64::consts::PI;
        let channels = |c: Rgb| [c.r, c.g, c.b].map(f64::from);
        let (up, side, down) = (channels(SKY.up), channels(SKY.side), channels(SKY.down));
        for k in 0..3 {
            let faces_up = pi * (side[k] + 2.0 * up[k]) / 3.0;
            let faces_down = pi * (side[k] + 2.0 * down[k]) / 3.0;
            let faces_sideways = pi * side[k] + 2.0 * (up[k] + down[k] - 2.0 * side[k]) / 3.0;
            for (n, expected) in [(Vec3::Y, faces_up), (-Vec3::Y, faces_down), (Vec3::X, faces_sideways)] {
                let found = irradiance(n)[k];
                assert!((found - expected).abs() < 1e-3, "{n}: {found}, not {expected}");
            }
        }
    }
}
