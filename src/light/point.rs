//! A point light, the same in all directions.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `position` | `[x, y, z]` | m | required |
//! | `intensity` | number or `[r, g, b]` | W sr^-1 | required |
//! | `falloff` | `"inverse-square"` or `"none"` | | `"inverse-square"` |
//!
//! ```toml
//! [[light]]
//! point = { position = [0, 3, 0], intensity = [40, 40, 36] }
//! ```
//!
//! With `falloff = "none"` the irradiance does not depend on the distance, as in the first ray
//! tracers.

use serde::Deserialize;

use super::{Falloff, LightBounds, LightKind, LightSample, OrientationCone, is_facing, point_bounds, sample_point};
use crate::{
    math::{DVec3, Rgb, Vec2, Vec3, WorkingSpace},
    value::{Point, Problem, RgbFactor},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointDesc {
    pub position: Point,
    pub intensity: RgbFactor,
    #[serde(default)]
    pub falloff: Falloff,
}

impl PointDesc {
    pub fn compile(&self, origin: DVec3) -> Result<PointLight, Problem> {
        Ok(PointLight {
            position: self.position.relative_to(origin),
            intensity: self.intensity.0,
            falloff: self.falloff,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct PointLight {
    pub position: Vec3,
    pub intensity: Rgb,
    pub falloff: Falloff,
}

impl PointLight {
    /// A light whose irradiance falls with the square of the distance.
    pub fn new(position: Vec3, intensity: Rgb) -> Self {
        let falloff = Falloff::default();
        Self {
            position,
            intensity,
            falloff,
        }
    }
}

impl LightKind for PointLight {
    #[inline]
    fn sample(&self, from: Vec3, _u: Vec2) -> Option<LightSample> {
        sample_point(self.position, from, self.falloff, |_| self.intensity)
    }

    fn bounds(&self) -> Option<LightBounds> {
        point_bounds(self.position, self.falloff, self.intensity, OrientationCone::ALL)
    }

    fn reaches(&self, p: Vec3, n: Vec3) -> bool {
        is_facing(n, self.position - p)
    }

    fn strength(&self) -> (Rgb, &'static str) {
        (self.intensity, "W sr^-1")
    }

    fn convert_colors(&mut self, space: WorkingSpace) {
        self.intensity = space.from_rec709(self.intensity);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn irradiance_falls_with_the_square_of_the_distance_or_not_at_all() {
        let light = |falloff| PointLight {
            position: Vec3::new(0.0, 2.0, 0.0),
            intensity: Rgb::gray(8.0),
            falloff,
        };
        let at = |falloff, y| light(falloff).sample(Vec3::new(0.0, y, 0.0), Vec2::ZERO).expect("lit");
        assert_eq!(at(Falloff::InverseSquare, 0.0).li, Rgb::gray(2.0));
        assert_eq!(at(Falloff::InverseSquare, -2.0).li, Rgb::gray(0.5));
        assert_eq!(at(Falloff::None, -2.0).li, Rgb::gray(8.0));
        assert_eq!(at(Falloff::None, -2.0).wi, Vec3::Y);
        assert_eq!(at(Falloff::None, -2.0).distance, 4.0);
    }
}
