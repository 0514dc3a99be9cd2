//! The scale, rotation and offset of a texture's coordinates.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `scale` | number other than 0 or `[s, t]`: multiplies s and t, so 2 repeats the texture twice | | 1 |
//! | `rotate` | number: rotates (s, t) about (0, 0) from s towards t, which rotates the texture the other way | degrees | 0 |
//! | `offset` | `[s, t]`: is added last | | `[0, 0]` |
//!
//! ```toml
//! [texture.tiles]
//! image = { file = "tiles.png" }
//! transform = { scale = 4, rotate = 45, offset = [0.5, 0] }
//! ```
//!
//! The order and the signs are those of glTF's KHR_texture_transform, applied to s and t (t = 0 is the bottom row). The
//! transform comes after the mapping and before wrapping.

use serde::Deserialize;

use crate::{
    math::{DAffine2, DMat2, DVec2, Vec2, float, origin, trig},
    value::{Finite, List, OneOrEach, Scale},
};

/// The transform of texture coordinates in a scene file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StTransformDesc {
    pub offset: Option<List<Finite, 2>>,
    pub rotate: Option<Finite>,
    pub scale: Option<OneOrEach<Scale, 2>>,
}

impl StTransformDesc {
    pub fn compile(&self) -> StTransform {
        let vector = |[s, t]: [Finite; 2]| Vec2::new(s.0, t.0);
        let offset = self.offset.map_or(Vec2::ZERO, |list| vector(list.0));
        let scale = self
            .scale
            .map_or(Vec2::ONE, |each| Vec2::from_array(each.0.map(f32::from)));
        StTransform::new(offset, self.rotate.map_or(0.0, |r| r.0), scale)
    }
}

/// An affine map of s and t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StTransform {
    /// The images of (1, 0) and (0, 1), relative to that of (0, 0).
    axes: [Vec2; 2],
    offset: Vec2,
    /// The same map in double precision, of the decimal numbers in the file.
    exact: DAffine2,
}

impl StTransform {
    pub const IDENTITY: Self = Self {
        axes: [Vec2::X, Vec2::Y],
        offset: Vec2::ZERO,
        exact: DAffine2::IDENTITY,
    };

    /// Scales, then rotates by `degrees` from s towards t, then moves.
    pub fn new(offset: Vec2, degrees: f32, scale: Vec2) -> Self {
        Self::turned(offset, degrees, float::decimal(degrees).to_radians(), scale)
    }

    /// The same with the angle in double precision as well, in `radians`.
    fn turned(offset: Vec2, degrees: f32, radians: f64, scale: Vec2) -> Self {
        let right_angle = |sin: f32, cos: f32| ((sin, cos), (f64::from(sin), f64::from(cos)));
        let ((sin, cos), (exact_sin, exact_cos)) = match degrees.rem_euclid(360.0) {
            0.0 => right_angle(0.0, 1.0),
            90.0 => right_angle(1.0, 0.0),
            180.0 => right_angle(0.0, -1.0),
            270.0 => right_angle(-1.0, 0.0),
            d => (trig::sin_cos(trig::radians(d)), libm::sincos(radians)),
        };
        let exact = |v: Vec2| DVec2::from_array(v.to_array().map(float::decimal));
        let exact_scale = exact(scale);
        let exact_axes = DMat2::from_cols(
            DVec2::new(exact_cos, exact_sin) * exact_scale.x,
            DVec2::new(-exact_sin, exact_cos) * exact_scale.y,
        );
        Self {
            axes: [Vec2::new(cos, sin) * scale.x, Vec2::new(-sin, cos) * scale.y],
            offset,
            exact: DAffine2::from_mat2_translation(exact_axes, exact(offset)),
        }
    }

    /// The same for coordinates u and v = 1 - t, which scales, then rotates by `radians` from v towards u, then moves: glTF's
    /// KHR_texture_transform.
    pub fn of_uv(offset: Vec2, radians: f32, scale: Vec2) -> Self {
        let mut turned = Self::turned(offset, radians.to_degrees(), float::decimal(radians), scale);
        let [_, t] = turned.axes;
        turned.offset = Vec2::new(offset.x - t.x, 1.0 - t.y - offset.y);
        let (t, offset) = (turned.exact.matrix2.y_axis, turned.exact.translation);
        turned.exact.translation = DVec2::new(offset.x - t.x, 1.0 - t.y - offset.y);
        turned
    }

    #[inline]
    pub fn point(&self, st: Vec2) -> Vec2 {
        self.vector(st) + self.offset
    }

    /// The image of `st` in double precision.
    pub(super) fn exact(&self, st: DVec2) -> DVec2 {
        self.exact.transform_point2(st)
    }

    /// The image of `origin`, less by whole multiples of the `periods` of s and t. A period of 0 has none.
    pub(super) fn offset_of(&self, origin: Vec2, periods: DVec2) -> Vec2 {
        less_periods(self.exact(origin.as_dvec2()), periods)
    }

    /// The same map with an offset that is less by whole multiples of `periods`, if it is far from 0.
    pub(super) fn near(self, periods: DVec2) -> Self {
        if f64::from(self.offset.abs().max_element()) < origin::FAR {
            return self;
        }
        let offset = self.offset_of(Vec2::ZERO, periods);
        Self { offset, ..self }
    }

    /// The image of a difference of two points.
    #[inline]
    pub fn vector(&self, d: Vec2) -> Vec2 {
        self.axes[0] * d.x + self.axes[1] * d.y
    }
}

/// A point less by whole multiples of the `periods` of its coordinates. A period of 0 has none.
pub(super) fn less_periods(point: DVec2, periods: DVec2) -> Vec2 {
    (point - whole_periods(point, periods)).as_vec2()
}

/// The whole multiples of the `periods` of its coordinates that are nearest to a point; 0 for a period of 0.
pub(super) fn whole_periods(point: DVec2, periods: DVec2) -> DVec2 {
    let whole = |x: f64, period: f64| {
        if period > 0.0 {
            (x / period).round() * period
        } else {
            0.0
        }
    };
    DVec2::new(whole(point.x, periods.x), whole(point.y, periods.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_comes_first_then_rotation_then_offset() {
        let t = StTransform::new(Vec2::new(10.0, 20.0), 90.0, Vec2::new(2.0, 3.0));
        assert_eq!(t.point(Vec2::ZERO), Vec2::new(10.0, 20.0));
        assert_eq!(t.point(Vec2::X), Vec2::new(10.0, 22.0));
        assert_eq!(t.point(Vec2::Y), Vec2::new(7.0, 20.0));
        assert_eq!(t.vector(Vec2::ONE), Vec2::new(-3.0, 2.0));
    }

    #[test]
    fn the_identity_changes_no_bit() {
        let st = Vec2::new(0.123_456_7, -7.654_321);
        assert_eq!(StTransform::IDENTITY.point(st), st);
        assert_eq!(StTransformDesc::default().compile(), StTransform::IDENTITY);
    }

    #[test]
    fn files_give_one_factor_or_two() {
        let read = |text| toml::from_str::<StTransformDesc>(text).unwrap().compile();
        let both = StTransform::new(Vec2::ZERO, 0.0, Vec2::splat(2.0));
        assert_eq!(read("scale = 2"), both);
        assert_eq!(read("scale = [2, 2.0]"), both);
        assert_eq!(
            read("rotate = 450\noffset = [1, 0]").point(Vec2::X),
            Vec2::new(1.0, 1.0)
        );
        assert!(toml::from_str::<StTransformDesc>("scale = nan").is_err());
        assert!(toml::from_str::<StTransformDesc>("angle = 1").is_err());
    }
}
