//! A light at a point, or a small ball, the same in all directions.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `position` | `[x, y, z]` | m | required |
//! | `intensity` | number or `[r, g, b]`; with `ies` a factor of the file's intensities | W sr^-1 | this or `power`; 1 with `ies` |
//! | `power` | number or `[r, g, b]`, of all its light | W | this or `intensity` |
//! | `ies` | path of an IES file, relative to the scene file: the intensity in each direction | cd | none |
//! | `target` | with `ies`, a point that the lamp faces, `[x, y, z]` | m | this or `direction` |
//! | `direction` | with `ies`, the direction that the lamp faces, `[x, y, z]` | | `[0, -1, 0]` |
//! | `up` | with `ies`, the direction in which its horizontal angle 0 lies | | `[0, 1, 0]`; for a lamp that faces up or down `[0, 0, -1]` |
//! | `temperature` | of a black body, which colours the light and keeps its luminance, from 500 to 100000 | K | white |
//! | `exposure` | number of stops from -100 to 100: the light is `2^exposure` times as strong | | 0 |
//! | `radius` | of the ball, at least 0 | m | 0 |
//! | `camera` | whether the camera sees the ball; mirrors and glass always show it | | `false` |
//! | `reflections` | whether mirrors and other surfaces reflect its picture | | `true` |
//! | `falloff` | `"inverse-square"` or `"none"` | | `"inverse-square"` |
//!
//! ```toml
//! [[light]]
//! point = { position = [0, 3, 0], intensity = [40, 40, 36], radius = 0.1 }
//! ```
//!
//! With a `radius` shadows are soft, and the light behaves as [`sphere`](sphere.md). Blender's points and spots give the
//! same light where their Soft Falloff is off; with it, light at the distance d of a lamp of radius r is
//! `d^2 / (d^2 + r^2)` times as strong. With `falloff = "none"` the irradiance does not depend on the distance, as in the
//! first ray tracers; the light has no `radius` then.
//!
//! ## IES files
//!
//! Manufacturers of lamps measure the light of each in all directions and publish an IES file of it (ANSI/IES
//! LM-63, the versions of 1986 to 2019).
//!
//! ```toml
//! [[light]]
//! point = { position = [0, 2.6, 0], ies = "downlight.ies", temperature = 3000 }
//! ```
//!
//! The lamp has the intensities of the file, times its multiplier and ballast factors. They are in candela, of which 683 are
//! 1 W sr^-1, as in glTF files with `light_units = "photometric"`; `exposure` and `intensity` change them all. With a `power` the
//! file says only how the light is spread, and all of it together is `power`. Between the angles of the file the intensity is
//! interpolated linearly, and directions that the file leaves out are dark.
//!
//! The vertical angle 0 of a lamp of type C, the usual one, lies in `direction`: it is the nadir of a lamp that hangs. The
//! horizontal angle 0 lies towards `up`, and 90 to the left of that as seen along `direction`: counter-clockwise as seen from
//! behind the lamp. Lamps of type A and B face their angles 0 and 0; vertical angles rise towards `up`, and horizontal ones to the
//! right. Files with a tilt (`TILT=INCLUDE`) are refused.

use std::f32::consts::PI;

use serde::Deserialize;

use super::{
    Falloff, IesFile, LightBounds, LightFind, LightKind, LightSample, LightTables, OrientationCone, Sidedness, Sight,
    aim,
    ball::Ball,
    beam::{Beam, BeamScale},
    is_facing, point_bounds, sample_point, temperature,
};
use crate::{
    math::{Rgb, Vec2, Vec3, WorkingSpace},
    shape::{Shape, ShapeHit},
    value::{Direction, Finite, NonNegative, Point, Positive, Problem, RgbFactor, Spanned, Stops},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointDesc {
    pub position: Spanned<Point>,
    pub intensity: Option<RgbFactor>,
    pub power: Option<RgbFactor>,
    pub ies: Option<Spanned<String>>,
    pub target: Option<Spanned<Point>>,
    pub direction: Option<Spanned<Direction>>,
    pub up: Option<Spanned<Direction>>,
    pub temperature: Option<Spanned<Finite>>,
    pub exposure: Option<Stops>,
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
            ies: None,
            target: None,
            direction: None,
            up: None,
            temperature: None,
            exposure: None,
            radius: None,
            camera: false,
            reflections: None,
            falloff: Falloff::InverseSquare,
        }
    }

    /// The file of its profile, if it has one.
    pub fn ies(&self) -> Option<IesFile<'_>> {
        let sidedness = Sidedness::Both;
        self.ies.as_ref().map(|name| IesFile { name, sidedness })
    }

    pub fn compile(&self, find: &LightFind<'_>) -> Result<PointLight, Problem> {
        let scale = self.power.map_or(BeamScale::File, |_| BeamScale::Power);
        let up = self.up.as_ref().map(|up| *up.get_ref());
        let beam = Beam::new(&self.ies, (self.axis()?, up), scale, find)?;
        let intensity = match (self.intensity, self.power) {
            (Some(intensity), None) => intensity.0,
            (None, Some(power)) if beam.is_some() => power.0,
            (None, Some(power)) => power.0 / (4.0 * PI),
            (None, None) if beam.is_some() => Rgb::WHITE,
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
            // A ball without area is a point.
            Some(radius) if radius.get_ref().0 * radius.get_ref().0 >= f32::MIN_POSITIVE => {
                if self.falloff == Falloff::None {
                    return Err(Problem::at(radius.span(), "a light without falloff has no `radius`"));
                }
                Some(Ball::new(*position, Positive(radius.get_ref().0), find.origin, sight)?)
            }
            _ => None,
        };
        Ok(PointLight {
            position: position.relative_to(find.origin),
            intensity: intensity * temperature::factor(&self.temperature, self.exposure)?,
            falloff: self.falloff,
            ball,
            beam,
        })
    }

    /// The unit direction that the lamp of an IES file faces.
    fn axis(&self) -> Result<Vec3, Problem> {
        let [direction, up] = [("direction", &self.direction), ("up", &self.up)]
            .map(|(name, given)| given.as_ref().map(|given| (name, given.span())));
        let target = self.target.as_ref().map(|given| ("target", given.span()));
        if let (None, Some((name, span))) = (&self.ies, target.clone().or(direction.clone()).or(up)) {
            let message = format!("`{name}` turns the light of `ies`, which is not given");
            return Err(Problem::at(span, message));
        }
        if target.or(direction).is_none() {
            return Ok(Vec3::NEG_Y);
        }
        aim::axis("point", &self.position, &self.target, &self.direction)
    }
}

#[derive(Clone, Copy, Debug)]
pub struct PointLight {
    pub position: Vec3,
    /// In W sr^-1; with a beam the factor of its intensities.
    pub intensity: Rgb,
    pub falloff: Falloff,
    /// Its surface, if it has one.
    pub ball: Option<Ball>,
    /// The distribution of its light, if it is not the same in all directions.
    pub beam: Option<Beam>,
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
            beam: None,
        }
    }

    /// The intensity in the unit direction `w`, in W sr^-1.
    #[inline]
    fn towards(&self, tables: &LightTables<'_>, w: Vec3) -> Rgb {
        match &self.beam {
            None => self.intensity,
            Some(beam) => self.intensity * beam.intensity(tables, w),
        }
    }

    /// Samples a light with `factor` of this intensity in the unit direction away from it.
    #[inline]
    pub(super) fn sample_by(
        &self,
        tables: &LightTables<'_>,
        from: Vec3,
        u: Vec2,
        factor: impl Fn(Vec3) -> f32,
    ) -> Option<LightSample> {
        if self.ball.is_none() && self.beam.is_none() {
            let intensity = |wi: Vec3| self.intensity * factor(-wi);
            return sample_point(self.position, from, self.falloff, intensity);
        }
        self.sample_formed(tables, from, u, factor)
    }

    /// The same for a light with a size or a beam; apart, so that the plain one is small enough to be inlined.
    #[inline(never)]
    fn sample_formed(
        &self,
        tables: &LightTables<'_>,
        from: Vec3,
        u: Vec2,
        factor: impl Fn(Vec3) -> f32,
    ) -> Option<LightSample> {
        let intensity = |wi: Vec3| self.towards(tables, -wi) * factor(-wi);
        match &self.ball {
            None => sample_point(self.position, from, self.falloff, intensity),
            Some(ball) => ball.sample(from, u, intensity),
        }
    }

    /// The bounds of a light that shines in these directions.
    pub(super) fn bounds_within(&self, tables: &LightTables<'_>, directions: OrientationCone) -> Option<LightBounds> {
        let largest = self.beam.map_or(1.0, |beam| beam.max_intensity(tables));
        let bounds = point_bounds(self.position, self.falloff, self.intensity * largest, directions)?;
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
    fn sample(&self, tables: &LightTables<'_>, from: Vec3, u: Vec2) -> Option<LightSample> {
        self.sample_by(tables, from, u, |_| 1.0)
    }

    fn bounds(&self, tables: &LightTables<'_>) -> Option<LightBounds> {
        let directions = self
            .beam
            .map_or(OrientationCone::ALL, |beam| beam.directions(tables, PI));
        self.bounds_within(tables, directions)
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

    fn seen(&self, tables: &LightTables<'_>, from: Vec3, w: Vec3, hit: &ShapeHit) -> (Rgb, f32) {
        let seen = self.ball.map(|ball| ball.seen(from, w, hit, self.towards(tables, -w)));
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
        let tables = LightTables::NONE;
        let at = |falloff, y| {
            let sample = light(falloff).sample(&tables, Vec3::new(0.0, y, 0.0), Vec2::ZERO);
            sample.expect("lit")
        };
        assert_eq!(at(Falloff::InverseSquare, 0.0).li, Rgb::gray(2.0));
        assert_eq!(at(Falloff::InverseSquare, -2.0).li, Rgb::gray(0.5));
        assert_eq!(at(Falloff::None, -2.0).li, Rgb::gray(8.0));
        assert_eq!(at(Falloff::None, -2.0).wi, Vec3::Y);
        assert_eq!(at(Falloff::None, -2.0).distance, 4.0);
    }
}
