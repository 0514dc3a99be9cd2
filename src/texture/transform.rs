//! The scale, rotation and offset of a texture's coordinates.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `scale` | number or `[s, t]`: multiplies s and t, so 2 repeats the texture twice | | 1 |
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
    math::{Vec2, trig},
    value::{Finite, OneOrEach},
};

/// The transform of texture coordinates in a scene file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StTransformDesc {
    pub offset: Option<[Finite; 2]>,
    pub rotate: Option<Finite>,
    pub scale: Option<OneOrEach<Finite, 2>>,
}

impl StTransformDesc {
    pub fn compile(&self) -> StTransform {
        let vector = |[s, t]: [Finite; 2]| Vec2::new(s.0, t.0);
        let offset = self.offset.map_or(Vec2::ZERO, vector);
        let scale = self.scale.map_or(Vec2::ONE, |each| vector(each.0));
        StTransform::new(offset, self.rotate.map_or(0.0, |r| r.0), scale)
    }
}

/// An affine map of s and t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StTransform {
    /// The images of (1, 0) and (0, 1), relative to that of (0, 0).
    axes: [Vec2; 2],
    offset: Vec2,
}

impl StTransform {
    pub const IDENTITY: Self = Self {
        axes: [Vec2::X, Vec2::Y],
        offset: Vec2::ZERO,
    };

    /// Scales, then rotates by `degrees` from s towards t, then moves.
    pub fn new(offset: Vec2, degrees: f32, scale: Vec2) -> Self {
        let (sin, cos) = match degrees.rem_euclid(360.0) {
            0.0 => (0.0, 1.0),
            90.0 => (1.0, 0.0),
            180.0 => (0.0, -1.0),
            270.0 => (-1.0, 0.0),
            d => trig::sin_cos(trig::radians(d)),
        };
        Self {
            axes: [Vec2::new(cos, sin) * scale.x, Vec2::new(-sin, cos) * scale.y],
            offset,
        }
    }

    /// The same for coordinates u and v = 1 - t, which scales, then rotates by `radians` from v towards u, then moves: glTF's
    /// KHR_texture_transform.
    pub fn of_uv(offset: Vec2, radians: f32, scale: Vec2) -> Self {
        let turned = Self::new(Vec2::ZERO, radians.to_degrees(), scale);
        let [_, t] = turned.axes;
        let offset = Vec2::new(offset.x - t.x, 1.0 - t.y - offset.y);
        Self { offset, ..turned }
    }

    #[inline]
    pub fn point(&self, st: Vec2) -> Vec2 {
        self.vector(st) + self.offset
    }

    /// The image of a difference of two points.
    #[inline]
    pub fn vector(&self, d: Vec2) -> Vec2 {
        self.axes[0] * d.x + self.axes[1] * d.y
    }
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
