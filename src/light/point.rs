//! A light at a point, or a small ball, the same in all directions.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `position` | `[x, y, z]` | m | required |
//! | `intensity` | number or `[r, g, b]` | W sr^-1 | this or `power` |
//! | `power` | number or `[r, g, b]`, of all its light | W | this or `intensity` |
//! | `temperature` | of a black body, which colours the light and keeps its luminance, from 500 to 100000 | K | white |
//! | `exposure` | number of stops: the light is `2^exposure` times as strong | | 0 |
//! | `radius` | of the ball, at least 0 | m | 0 |
//! | `camera` | whether the camera sees the ball | | `false` |
//! | `reflections` | whether mirrors and other surfaces reflect its picture | | `true` |
//! | `falloff` | `"inverse-square"` or `"none"` | | `"inverse-square"` |
//!
//! ```toml
//! [[light]]
//! point = { position = [0, 3, 0], intensity = [40, 40, 36], radius = 0.1 }
//! ```
//!
//! With a `radius` shadows are soft, and the light behaves as [`sphere`](sphere.md). With `falloff = "none"` the irradiance does
//! not depend on the distance, as in the first ray tracers; the light has no `radius` then.

use std::f32::consts::PI;

use serde::Deserialize;

use super::{
    Falloff, LightBounds, LightKind, LightSample, OrientationCone, Sight, ball::Ball, is_facing, point_bounds,
    sample_point, temperature,
};
use crate::{
    math::{DVec3, Rgb, Vec2, Vec3, WorkingSpace},
    shape::{Shape, ShapeHit},
    value::{Finite, NonNegative, Point, Positive, Problem, RgbFactor, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointDesc {
    pub position: Spanned<Point>,
    pub intensity: Option<RgbFactor>,
    pub power: Option<RgbFactor>,
    pub temperature: Option<Spanned<Positive>>,
    pub exposure: Option<Finite>,
    pub radius: Option<Spanned<NonNegative>>,
    #[serde(default)]
    pub camera: bool,
    pub reflections: Option<bool>,
    #[serde(default)]
    pub falloff: Falloff,
}

impl PointDesc {
    /// A point of this intensity, in W sr^-1.
    pub fn new(position: Spanned<Point>, intensity: RgbFactor) -> Self {
        Self {
            position,
            intensity: Some(intensity),
            power: None,
            temperature: None,
            exposure: None,
            radius: None,
            camera: false,
            reflections: None,
            falloff: Falloff::InverseSquare,
        }
    }

    /// The light, if it were the same in all directions.
    pub fn compile(&self, origin: DVec3) -> Result<PointLight, Problem> {
        let intensity = match (self.intensity, self.power) {
            (Some(intensity), None) => intensity.0,
            (None, Some(power)) => power.0 / (4.0 * PI),
            (None, None) => {
                let message = "give its strength by `intensity` or by `power`";
                return Err(Problem::at(self.position.span(), message));
            }
            (Some(_), Some(_)) => {
                let message = "`intensity` and `power` are both given";
                return Err(Problem::at(self.position.span(), message));
            }
        };
        let position = self.position.get_ref();
        let sight = Sight {
            camera: self.camera,
            reflections: self.reflections.unwrap_or(true),
        };
        let ball = match &self.radius {
            Some(radius) if radius.get_ref().0 > 0.0 => {
                if self.falloff == Falloff::None {
                    return Err(Problem::at(radius.span(), "a light without falloff has no `radius`"));
                }
                Some(Ball::new(*position, Positive(radius.get_ref().0), origin, sight)?)
            }
            _ => None,
        };
        Ok(PointLight {
            position: position.relative_to(origin),
            intensity: intensity * temperature::factor(&self.temperature, self.exposure)?,
            falloff: self.falloff,
            ball,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct PointLight {
    pub position: Vec3,
    pub intensity: Rgb,
    pub falloff: Falloff,
    /// Its surface, if it has one.
    pub ball: Option<Ball>,
}

impl PointLight {
    /// A light whose irradiance falls with the square of the distance.
    pub fn new(position: Vec3, intensity: Rgb) -> Self {
        let falloff = Falloff::default();
        Self {
            position,
            intensity,
            falloff,
            ball: None,
        }
    }

    /// Samples a light with `factor` of this intensity in the unit direction away from it.
    #[inline]
    pub(super) fn sample_by(&self, from: Vec3, u: Vec2, factor: impl Fn(Vec3) -> f32) -> Option<LightSample> {
        let intensity = |wi: Vec3| self.intensity * factor(-wi);
        match &self.ball {
            None => sample_point(self.position, from, self.falloff, intensity),
            Some(ball) => ball.sample(from, u, intensity),
        }
    }

    /// The bounds of a light that shines in these directions.
    pub(super) fn bounds_within(&self, directions: OrientationCone) -> Option<LightBounds> {
        let bounds = point_bounds(self.position, self.falloff, self.intensity, directions)?;
        Some(match &self.ball {
            None => bounds,
            Some(ball) => LightBounds {
                bounds: ball.bounds(),
                ..bounds
            },
        })
    }
}

impl LightKind for PointLight {
    #[inline]
    fn sample(&self, from: Vec3, u: Vec2) -> Option<LightSample> {
        self.sample_by(from, u, |_| 1.0)
    }

    fn bounds(&self) -> Option<LightBounds> {
        self.bounds_within(OrientationCone::ALL)
    }

    fn reaches(&self, p: Vec3, n: Vec3) -> bool {
        self.ball.is_some() || is_facing(n, self.position - p)
    }

    fn strength(&self) -> (Rgb, &'static str) {
        (self.intensity, "W sr^-1")
    }

    fn convert_colors(&mut self, space: WorkingSpace) {
        self.intensity = space.from_rec709(self.intensity);
    }

    fn has_size(&self) -> bool {
        self.ball.is_some()
    }

    fn surface(&self) -> Option<(Shape, Sight)> {
        self.ball.map(|ball| (ball.shape, ball.sight))
    }

    fn seen(&self, from: Vec3, w: Vec3, hit: &ShapeHit) -> (Rgb, f32) {
        let seen = self.ball.map(|ball| ball.seen(from, w, hit, self.intensity));
        seen.unwrap_or((Rgb::BLACK, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn irradiance_falls_with_the_square_of_the_distance_or_not_at_all() {
        let light = |falloff| PointLight {
            falloff,
            ..PointLight::new(Vec3::new(0.0, 2.0, 0.0), Rgb::gray(8.0))
        };
        let at = |falloff, y| light(falloff).sample(Vec3::new(0.0, y, 0.0), Vec2::ZERO).expect("lit");
        assert_eq!(at(Falloff::InverseSquare, 0.0).li, Rgb::gray(2.0));
        assert_eq!(at(Falloff::InverseSquare, -2.0).li, Rgb::gray(0.5));
        assert_eq!(at(Falloff::None, -2.0).li, Rgb::gray(8.0));
        assert_eq!(at(Falloff::None, -2.0).wi, Vec3::Y);
        assert_eq!(at(Falloff::None, -2.0).distance, 4.0);
    }
}
