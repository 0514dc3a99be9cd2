//! A spotlight: a point light that shines into a cone.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `position` | `[x, y, z]` | m | required |
//! | `target` | a point on the axis, `[x, y, z]` | m | this or `direction` |
//! | `direction` | direction of the axis, `[x, y, z]` | | this or `target` |
//! | `cone_angle` | angle from the axis to the edge of the cone, above 0 and at most 180 | degrees | required |
//! | `penumbra_angle` | width of the soft edge inside the cone, from 0 to `cone_angle` | degrees | 0 |
//! | `intensity` | number or `[r, g, b]`, along the axis; with `ies` a factor of the file's intensities | W sr^-1 | this or `power`; 1 with `ies` |
//! | `power` | number or `[r, g, b]`, 4 pi times the `intensity`: the light that it would give without its cone | W | this or `intensity` |
//! | `ies` | path of an IES file, relative to the scene file: the intensity in each direction | cd | none |
//! | `up` | with `ies`, the direction in which its horizontal angle 0 lies | | `[0, 1, 0]`; for a lamp that faces up or down `[0, 0, -1]` |
//! | `temperature` | of a black body, which colours the light and keeps its luminance, from 500 to 100000 | K | white |
//! | `exposure` | number of stops from -100 to 100: the light is `2^exposure` times as strong | | 0 |
//! | `radius` | of the ball that shines, at least 0 | m | 0 |
//! | `camera` | whether the camera sees the ball; mirrors and glass always show it | | `false` |
//! | `reflections` | whether mirrors and other surfaces reflect its picture | | `true` |
//! | `falloff` | `"inverse-square"` or `"none"` | | `"inverse-square"` |
//!
//! ```toml
//! [[light]]
//! spot = { position = [0, 5, 0], target = [0, 0, 0], cone_angle = 30, penumbra_angle = 5, intensity = 100 }
//! ```
//!
//! Blender's spots of as many watts of `power` give the same picture, with a `radius` if their Soft Falloff is off. With a `radius`
//! shadows are soft, and the light behaves as [`sphere`](sphere.md). With `ies` the cone cuts off the light of the file; the page
//! of [`point`](point.md) says the rest.
//!
//! Within `cone_angle - penumbra_angle` of the axis the intensity is full. From there to `cone_angle` it falls by a
//! smoothstep over the cosine, as in Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th ed., section 12.2.1.

use serde::Deserialize;

use super::{
    Falloff, IesFile, LightBounds, LightFind, LightKind, LightSample, LightTables, OrientationCone, Sidedness, Sight,
    aim,
    point::{PointDesc, PointLight},
};
use crate::{
    math::{Rgb, Vec2, Vec3, WorkingSpace, trig},
    shape::{Shape, ShapeHit},
    value::{Direction, Finite, NonNegative, Point, Positive, Problem, RgbFactor, Spanned, Stops},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpotDesc {
    pub position: Spanned<Point>,
    pub target: Option<Spanned<Point>>,
    pub direction: Option<Spanned<Direction>>,
    pub cone_angle: Spanned<Positive>,
    #[serde(default)]
    pub penumbra_angle: Option<Spanned<NonNegative>>,
    pub intensity: Option<RgbFactor>,
    pub power: Option<RgbFactor>,
    pub ies: Option<Spanned<String>>,
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

impl SpotDesc {
    /// The light without its cone.
    fn point(&self) -> PointDesc {
        PointDesc {
            position: self.position.clone(),
            intensity: self.intensity,
            power: self.power,
            ies: self.ies.clone(),
            target: self.target.clone().filter(|_| self.ies.is_some()),
            direction: self.direction.clone().filter(|_| self.ies.is_some()),
            up: self.up.clone(),
            temperature: self.temperature.clone(),
            exposure: self.exposure,
            radius: self.radius.clone(),
            camera: self.camera,
            reflections: self.reflections,
            falloff: self.falloff,
        }
    }

    /// The file of its profile, if it has one.
    pub fn ies(&self) -> Option<IesFile<'_>> {
        let sidedness = Sidedness::Both;
        self.ies.as_ref().map(|name| IesFile { name, sidedness })
    }

    pub fn compile(&self, find: &LightFind<'_>) -> Result<SpotLight, Problem> {
        let axis = aim::axis("spot", &self.position, &self.target, &self.direction)?;
        let cone = self.cone_angle.get_ref().0;
        if cone > 180.0 {
            let message = format!("expected an angle of at most 180, found {cone}");
            return Err(Problem::at(self.cone_angle.span(), message));
        }
        let penumbra = self.penumbra_angle.as_ref().map_or(0.0, |p| p.get_ref().0);
        if let Some(p) = self.penumbra_angle.as_ref().filter(|_| penumbra > cone) {
            let message = format!("`penumbra_angle` ({penumbra}) exceeds `cone_angle` ({cone})");
            return Err(Problem::at(p.span(), message));
        }
        Ok(SpotLight {
            point: self.point().compile(find)?,
            axis,
            cos_outer: trig::cos(trig::radians(cone)),
            cos_inner: trig::cos(trig::radians(cone - penumbra)),
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct SpotLight {
    /// The light without its cone.
    pub point: PointLight,
    /// The unit direction of the axis.
    pub axis: Vec3,
    pub cos_outer: f32,
    pub cos_inner: f32,
}

impl SpotLight {
    /// The fraction of the full intensity at an angle to the axis with this cosine.
    fn profile(&self, cos: f32) -> f32 {
        if cos >= self.cos_inner {
            return 1.0;
        }
        if cos <= self.cos_outer {
            return 0.0;
        }
        let x = (cos - self.cos_outer) / (self.cos_inner - self.cos_outer);
        x * x * (3.0 - 2.0 * x)
    }
}

impl LightKind for SpotLight {
    #[inline]
    fn sample(&self, tables: &LightTables<'_>, from: Vec3, u: Vec2) -> Option<LightSample> {
        self.point
            .sample_by(tables, from, u, |w| self.profile(w.dot(self.axis)))
    }

    fn bounds(&self, tables: &LightTables<'_>) -> Option<LightBounds> {
        let outer = trig::acos(self.cos_outer);
        if let Some(beam) = self.point.beam {
            return self.point.bounds_within(tables, beam.directions(tables, outer));
        }
        // The inner cone bounds the normals, the outer one the emission.
        let penumbra = outer - trig::acos(self.cos_inner);
        self.point.bounds_within(
            tables,
            OrientationCone {
                axis: self.axis,
                cos_o: self.cos_inner,
                cos_e: trig::cos(penumbra),
                sidedness: Sidedness::Front,
            },
        )
    }

    fn reaches(&self, p: Vec3, n: Vec3) -> bool {
        self.point.reaches(p, n)
    }

    fn strength(&self) -> (Rgb, &'static str) {
        self.point.strength()
    }

    fn convert_colors(&mut self, space: WorkingSpace) {
        self.point.convert_colors(space);
    }

    fn has_size(&self) -> bool {
        self.point.has_size()
    }

    fn surface(&self) -> Option<(Shape, Sight)> {
        self.point.surface()
    }

    fn seen(&self, tables: &LightTables<'_>, from: Vec3, w: Vec3, hit: &ShapeHit) -> (Rgb, f32) {
        let (l, pdf) = self.point.seen(tables, from, w, hit);
        (l * self.profile(-w.dot(self.axis)), pdf)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;

    fn spot(keys: &str) -> Result<SpotLight, String> {
        let text = format!("position = [0, 1, 0]\nintensity = 4\n{keys}");
        let desc: SpotDesc = toml::from_str(&text).map_err(|e| e.message().to_owned())?;
        desc.compile(&LightFind::nothing(DVec3::ZERO)).map_err(|p| p.message)
    }

    #[test]
    fn light_is_full_inside_gone_outside_and_fades_between() {
        let s = spot("target = [0, 0, 0]\ncone_angle = 45\npenumbra_angle = 15").expect("valid");
        let at = |degrees: f32| {
            let x = trig::tan(trig::radians(degrees));
            s.sample(&LightTables::NONE, Vec3::new(x, 0.0, 0.0), Vec2::ZERO)
                .map_or(0.0, |l| l.li.r * l.distance * l.distance)
        };
        assert!((at(0.0) - 4.0).abs() < 1e-5);
        assert!((at(29.9) - 4.0).abs() < 1e-4);
        assert!(at(38.0) > 0.5 && at(38.0) < 3.5);
        assert_eq!(at(45.1), 0.0);
        let above = Vec3::new(0.0, 2.0, 0.0);
        assert!(s.sample(&LightTables::NONE, above, Vec2::ZERO).is_none());
    }

    #[test]
    fn wrong_spots_are_refused_in_words() {
        let message = |keys| spot(keys).expect_err("refused");
        assert_eq!(message("cone_angle = 30"), "a spot needs `target` or `direction`");
        assert_eq!(
            message("target = [0, 1, 0]\ncone_angle = 30"),
            "`target` lies at `position`"
        );
        assert_eq!(
            message("direction = [0, 1, 0]\ncone_angle = 30\npenumbra_angle = 40"),
            "`penumbra_angle` (40) exceeds `cone_angle` (30)"
        );
        assert_eq!(
            message("direction = [0, 1, 0]\ncone_angle = 181"),
            "expected an angle of at most 180, found 181"
        );
    }
}
