//! A spotlight: a point light that shines into a cone.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `position` | `[x, y, z]` | m | required |
//! | `target` | a point on the axis, `[x, y, z]` | m | this or `direction` |
//! | `direction` | direction of the axis, `[x, y, z]` | | this or `target` |
//! | `cone_angle` | angle from the axis to the edge of the cone, above 0 and at most 180 | degrees | required |
//! | `penumbra_angle` | width of the soft edge inside the cone, from 0 to `cone_angle` | degrees | 0 |
//! | `intensity` | number or `[r, g, b]`, along the axis | W sr^-1 | required |
//! | `falloff` | `"inverse-square"` or `"none"` | | `"inverse-square"` |
//!
//! ```toml
//! [[light]]
//! spot = { position = [0, 5, 0], target = [0, 0, 0], cone_angle = 30, penumbra_angle = 5, intensity = 100 }
//! ```
//!
//! Within `cone_angle - penumbra_angle` of the axis the intensity is full. From there to `cone_angle` it falls by a
//! smoothstep over the cosine, as in Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th ed., section 12.2.1.

use serde::Deserialize;

use super::{
    Falloff, LightBounds, LightKind, LightSample, OrientationCone, Sidedness, is_facing, point_bounds, sample_point,
};
use crate::{
    math::{DVec3, Rgb, Vec2, Vec3, WorkingSpace, trig},
    value::{Direction, NonNegative, Point, Positive, Problem, RgbFactor, Spanned},
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
    pub intensity: RgbFactor,
    #[serde(default)]
    pub falloff: Falloff,
}

impl SpotDesc {
    pub fn compile(&self, origin: DVec3) -> Result<SpotLight, Problem> {
        let position = *self.position.get_ref();
        let axis = match (&self.target, &self.direction) {
            (Some(target), None) => (target.get_ref().0 - position.0)
                .try_normalize()
                .ok_or_else(|| Problem::at(target.span(), "`target` lies at `position`"))?
                .as_vec3(),
            (None, Some(direction)) => direction.get_ref().0,
            (Some(_), Some(direction)) => {
                return Err(Problem::at(direction.span(), "`target` and `direction` are both given"));
            }
            (None, None) => {
                return Err(Problem::at(
                    self.position.span(),
                    "a spot needs `target` or `direction`",
                ));
            }
        };
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
            position: position.relative_to(origin),
            axis,
            cos_outer: trig::cos(trig::radians(cone)),
            cos_inner: trig::cos(trig::radians(cone - penumbra)),
            intensity: self.intensity.0,
            falloff: self.falloff,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct SpotLight {
    pub position: Vec3,
    /// The unit direction of the axis.
    pub axis: Vec3,
    pub cos_outer: f32,
    pub cos_inner: f32,
    pub intensity: Rgb,
    pub falloff: Falloff,
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
    fn sample(&self, from: Vec3, _u: Vec2) -> Option<LightSample> {
        sample_point(self.position, from, self.falloff, |wi| {
            self.intensity * self.profile(-wi.dot(self.axis))
        })
    }

    fn bounds(&self) -> Option<LightBounds> {
        // The inner cone bounds the normals, the outer one the emission.
        let penumbra = trig::acos(self.cos_outer) - trig::acos(self.cos_inner);
        let directions = OrientationCone {
            axis: self.axis,
            cos_o: self.cos_inner,
            cos_e: trig::cos(penumbra),
            sidedness: Sidedness::Front,
        };
        point_bounds(self.position, self.falloff, self.intensity, directions)
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

    fn spot(keys: &str) -> Result<SpotLight, String> {
        let text = format!("position = [0, 1, 0]\nintensity = 4\n{keys}");
        let desc: SpotDesc = toml::from_str(&text).map_err(|e| e.message().to_owned())?;
        desc.compile(DVec3::ZERO).map_err(|p| p.message)
    }

    #[test]
    fn light_is_full_inside_gone_outside_and_fades_between() {
        let s = spot("target = [0, 0, 0]\ncone_angle = 45\npenumbra_angle = 15").expect("valid");
        let at = |degrees: f32| {
            let x = trig::tan(trig::radians(degrees));
            s.sample(Vec3::new(x, 0.0, 0.0), Vec2::ZERO)
                .map_or(0.0, |l| l.li.r * l.distance * l.distance)
        };
        assert!((at(0.0) - 4.0).abs() < 1e-5);
        assert!((at(29.9) - 4.0).abs() < 1e-4);
        assert!(at(38.0) > 0.5 && at(38.0) < 3.5);
        assert_eq!(at(45.1), 0.0);
        assert!(s.sample(Vec3::new(0.0, 2.0, 0.0), Vec2::ZERO).is_none());
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
