//! The mapping from points of a surface to the texture coordinates s and t.
//!
//! | kind | s, t |
//! |---|---|
//! | `uv` | the surface's own parameters u and v (the default) |
//! | `planar = { s = { axis, from, to }, t = { axis, from, to } }` | a coordinate of the object's own space: 0 at `from`, 1 at `to` |
//! | `spherical` | longitude of the normal around y, from +x towards +z over 360 degrees; latitude from the south pole |
//! | `asin` | asin(n.x)/pi + 0.5 and asin(n.y)/pi + 0.5 for the unit normal n |
//! | `object = { scale, rotate, offset }` | three coordinates: x, y and z of the object's own space, in metres |
//! | `world = { scale, rotate, offset }` | three coordinates: x, y and z of the world, in metres |
//! | `triplanar = { space, scale, rotate, offset, blend }` | two of these three coordinates, by the side that the surface faces |
//!
//! `axis` is `"x"`, `"y"` or `"z"`.
//!
//! `object` and `world` need no texture coordinates. Patterns that fill space, such as `noise`, run through the body as through a
//! block of stone; others show their s and t along the first two coordinates. `scale`, a number or `[x, y, z]`, multiplies the
//! coordinates; then `rotate = [x, y, z]` rotates them about the fixed x, y and z axes in this order (degrees); then
//! `offset = [x, y, z]` is added. A texture in `object` moves with its object, one in `world` stays while objects move through it.
//!
//! `triplanar` lays a picture onto a body without texture coordinates, from the sides of x, y and z: its width and
//! height are 1 m at a `scale` of 1. `space` is `"object"` (the default) or `"world"`. Between the sides the picture is
//! blended: over nothing with a `blend` of 0, over all of a ball with 1 (default 0.3). A bump takes its heights from it
//! as well; a normal map cannot be mapped so.
//!
//! ```toml
//! [texture.floor]
//! image = { file = "floor.bmp" }
//! mapping.planar = { s = { axis = "x", from = -40, to = 40 }, t = { axis = "z", from = -40, to = -200 } }
//! ```
//!
//! # Implementation
//!
//! A mapping also gives the size of a ray's footprint in s and t; for `spherical` and `asin` that is the footprint on a
//! sphere of the surface's curvature (meshes count as flat there).

use std::f32::consts::{PI, TAU};

use serde::Deserialize;

use super::{
    TexturePoint, TextureSpace,
    solid::{Solid, SolidDesc, SolidSpace},
    triplanar::{Triplanar, TriplanarDesc},
};
use crate::{
    math::{DVec3, Vec2, Vec3, trig},
    value::{Coordinate, Problem, Spanned},
};

/// The description of a mapping in a scene file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MappingDesc {
    #[default]
    #[serde(skip)]
    Default,
    Uv(NoKeys),
    Planar(PlanarDesc),
    Spherical(NoKeys),
    Asin(NoKeys),
    Object(SolidDesc),
    World(SolidDesc),
    Triplanar(TriplanarDesc),
}

/// A kind without keys.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoKeys {}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanarDesc {
    pub s: Spanned<RampDesc>,
    pub t: Spanned<RampDesc>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RampDesc {
    pub axis: Axis,
    pub from: Coordinate,
    pub to: Coordinate,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    X,
    Y,
    Z,
}

impl MappingDesc {
    /// The names of all mappings.
    pub const NAMES: &[&str] = &["uv", "planar", "spherical", "asin", "object", "world", "triplanar"];

    /// Compiles the mapping for a scene around `origin`.
    pub fn compile(&self, origin: DVec3) -> Result<Mapping, Problem> {
        Ok(match self {
            Self::Default | Self::Uv(_) => Mapping::Uv,
            Self::Planar(p) => Mapping::Planar {
                s: ramp(&p.s, origin)?,
                t: ramp(&p.t, origin)?,
            },
            Self::Spherical(_) => Mapping::Spherical,
            Self::Asin(_) => Mapping::Asin,
            Self::Object(solid) => Mapping::Solid(solid.compile(SolidSpace::Object, origin)),
            Self::World(solid) => Mapping::Solid(solid.compile(SolidSpace::World, origin)),
            Self::Triplanar(desc) => Mapping::Triplanar(desc.compile(origin)),
        })
    }

    /// Whether its coordinates follow from a point of a mesh in the object's own space.
    pub fn lies_on_mesh(&self) -> bool {
        match self {
            Self::Default | Self::Uv(_) | Self::Planar(_) | Self::Object(_) => true,
            Self::Spherical(_) | Self::Asin(_) | Self::World(_) | Self::Triplanar(_) => false,
        }
    }

    /// Whether it gives three coordinates, which it scales, rotates and moves itself.
    pub fn is_solid(&self) -> bool {
        matches!(self, Self::Object(_) | Self::World(_) | Self::Triplanar(_))
    }

    /// Whether each side of a body has its own s and t.
    pub fn has_sides(&self) -> bool {
        matches!(self, Self::Triplanar(_))
    }
}

fn ramp(desc: &Spanned<RampDesc>, origin: DVec3) -> Result<Ramp, Problem> {
    let r = desc.get_ref();
    if r.from == r.to {
        return Err(Problem::at(desc.span(), "`from` and `to` are the same"));
    }
    Ok(Ramp::new(r.axis as usize, [r.from.0, r.to.0], origin))
}

/// One coordinate, from 0 at a number to 1 at another.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    axis: usize,
    /// The coordinate of 0, in the object's own space and in the scene's.
    from: f32,
    from_in_scene: f32,
    /// From 0 to 1.
    extent: f32,
}

impl Ramp {
    /// Along axis 0 (x), 1 or 2 from one coordinate to the other, for a scene around `origin`.
    pub fn new(axis: usize, [from, to]: [f64; 2], origin: DVec3) -> Self {
        Self {
            axis,
            from: from as f32,
            from_in_scene: (from - origin[axis]) as f32,
            extent: (to - from) as f32,
        }
    }

    fn at(&self, p: Vec3, space: TextureSpace) -> f32 {
        let from = match space {
            TextureSpace::Object => self.from,
            TextureSpace::Scene => self.from_in_scene,
        };
        (p[self.axis] - from) / self.extent
    }

    /// The change over the step `dp`.
    fn slope(&self, dp: Vec3) -> f32 {
        dp[self.axis] / self.extent
    }
}

/// The mapping of a point to s and t.
#[derive(Clone, Copy, Debug)]
pub enum Mapping {
    Uv,
    /// The second texture coordinates of a mesh.
    SecondUv,
    Planar {
        s: Ramp,
        t: Ramp,
    },
    Spherical,
    Asin,
    /// Three coordinates.
    Solid(Solid),
    /// Two of three coordinates on each side.
    Triplanar(Triplanar),
}

impl Mapping {
    /// The map to three coordinates, if it has them.
    #[inline]
    pub fn solid(&self) -> Option<&Solid> {
        match self {
            Self::Solid(solid) => Some(solid),
            Self::Triplanar(triplanar) => Some(&triplanar.solid),
            _ => None,
        }
    }

    /// The map from three sides.
    #[inline]
    pub(super) fn triplanar(&self) -> Option<&Triplanar> {
        match self {
            Self::Triplanar(triplanar) => Some(triplanar),
            _ => None,
        }
    }

    /// Whether it reads the texture coordinates of a mesh.
    pub fn reads_uvs(&self) -> bool {
        matches!(self, Self::Uv | Self::SecondUv)
    }

    /// The texture coordinates; of three the first two.
    pub fn st(&self, at: &TexturePoint) -> Vec2 {
        let asin = |x: f32| trig::asin(x.clamp(-1.0, 1.0)) / PI + 0.5;
        match self {
            Self::Uv => at.uv,
            Self::SecondUv => at.vertex.second_uv,
            Self::Planar { s, t } => Vec2::new(s.at(at.p, at.space), t.at(at.p, at.space)),
            Self::Spherical => {
                let turn = trig::atan2(at.n.z, at.n.x) / TAU;
                Vec2::new(if turn < 0.0 { turn + 1.0 } else { turn }, asin(at.n.y))
            }
            Self::Asin => Vec2::new(asin(at.n.x), asin(at.n.y)),
            Self::Solid(solid) | Self::Triplanar(Triplanar { solid, .. }) => solid.place(at).truncate().as_vec2(),
        }
    }

    /// The whole numbers to which [`Mapping::st`] is relative.
    #[inline]
    pub(super) fn origin(&self, at: &TexturePoint) -> Vec2 {
        match self {
            Self::Uv => at.uv_origin,
            Self::SecondUv => at.vertex.second_uv_origin,
            Self::Planar { .. } | Self::Spherical | Self::Asin | Self::Solid(_) | Self::Triplanar(_) => Vec2::ZERO,
        }
    }

    /// Whether the coordinates are affine over a triangle.
    pub(super) fn is_affine(&self) -> bool {
        matches!(self, Self::Uv | Self::SecondUv | Self::Planar { .. } | Self::Solid(_))
    }

    /// Whether its coordinates are `uv`.
    pub(super) fn is_uv(&self) -> bool {
        matches!(self, Self::Uv)
    }

    /// Whether the tangents of a surface follow its coordinates.
    pub(super) fn has_tangents(&self) -> bool {
        matches!(self, Self::Uv | Self::SecondUv)
    }

    /// The steps of one unit of u and of v, in the frame of tangent and bitangent; of equal lengths where they are not known.
    pub(super) fn steps_in_tangents(&self, at: &TexturePoint) -> [Vec2; 2] {
        let along = at.dpdu.length();
        if along == 0.0 || matches!(self, Self::SecondUv) {
            return [Vec2::X, Vec2::Y];
        }
        let x = at.dpdv.dot(at.dpdu) / along;
        let y = (at.dpdv - at.dpdu * (x / along)).length();
        [Vec2::new(along, 0.0), Vec2::new(x, y)]
    }

    /// The footprint around `at` in s and t: what its axes become.
    #[inline]
    pub fn footprint(&self, at: &TexturePoint) -> [Vec2; 2] {
        if let Self::Uv = self {
            return at.footprint;
        }
        at.footprint.map(|duv| self.step(at, duv))
    }

    /// The change of s and t over the step `duv`.
    fn step(&self, at: &TexturePoint, duv: Vec2) -> Vec2 {
        let dp = at.dpdu * duv.x + at.dpdv * duv.y;
        let dn = dp * at.curvature;
        // Of asin; steep without bound at the rim.
        let slope = |x: f32| 1.0 / (PI * (1.0 - x * x).max(1e-6).sqrt());
        match self {
            Self::Uv => duv,
            Self::SecondUv => at.vertex.second_per_uv[0] * duv.x + at.vertex.second_per_uv[1] * duv.y,
            Self::Planar { s, t } => Vec2::new(s.slope(dp), t.slope(dp)),
            Self::Spherical => {
                let r2 = (at.n.x * at.n.x + at.n.z * at.n.z).max(1e-6);
                let turn = (at.n.x * dn.z - at.n.z * dn.x) / (TAU * r2);
                Vec2::new(turn, dn.y * slope(at.n.y))
            }
            Self::Asin => Vec2::new(dn.x * slope(at.n.x), dn.y * slope(at.n.y)),
            Self::Solid(solid) | Self::Triplanar(Triplanar { solid, .. }) => solid.step(at, duv).truncate(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(p: Vec3, n: Vec3) -> TexturePoint {
        TexturePoint {
            uv: Vec2::new(0.25, 0.75),
            ..TexturePoint::new(p, n)
        }
    }

    #[test]
    fn mappings_follow_their_formulas() {
        let place = at(Vec3::new(0.0, 7.0, -120.0), Vec3::new(0.0, 0.0, 1.0));
        assert_eq!(Mapping::Uv.st(&place), Vec2::new(0.25, 0.75));
        let ramp = |axis, from, to| Ramp::new(axis, [from, to], DVec3::ZERO);
        let planar = Mapping::Planar {
            s: ramp(0, -40.0, 40.0),
            t: ramp(2, -40.0, -200.0),
        };
        assert_eq!(planar.st(&place), Vec2::new(0.5, 0.5));
        assert_eq!(Mapping::Asin.st(&place), Vec2::new(0.5, 0.5));
        assert_eq!(Mapping::Spherical.st(&place), Vec2::new(0.25, 0.5));
        assert_eq!(Mapping::Spherical.st(&at(Vec3::ZERO, Vec3::Y)).y, 1.0);
    }

    #[test]
    fn a_planar_mapping_in_a_scene_far_away_counts_millimetres() {
        let origin = DVec3::new(431_250.0, 20.0, 5_649_830.0);
        let planar = Mapping::Planar {
            s: Ramp::new(0, [431_250.001, 431_250.003], origin),
            t: Ramp::new(2, [5_649_830.004, 5_649_830.0], origin),
        };
        let place = TexturePoint {
            space: TextureSpace::Scene,
            ..at(Vec3::new(0.002, 0.0, 0.001), Vec3::Y)
        };
        assert!((planar.st(&place) - Vec2::new(0.5, 0.75)).length() < 1e-5);
    }

    #[test]
    fn footprints_are_what_small_steps_on_a_sphere_change() {
        let radius = 2.5;
        let n = Vec3::new(0.48, 0.6, 0.64);
        let (dpdu, dpdv) = (n.cross(Vec3::Y).normalize() * 3.0, n.cross(Vec3::X).normalize() * 0.7);
        let place = TexturePoint {
            dpdu,
            dpdv,
            curvature: 1.0 / radius,
            footprint: [Vec2::new(1e-3, 2e-3), Vec2::new(-1e-3, 3e-3)],
            ..at(n * radius, n)
        };
        let ramp = |axis| Ramp::new(axis, [-3.0, 5.0], DVec3::ZERO);
        let planar = Mapping::Planar { s: ramp(0), t: ramp(2) };
        for mapping in [planar, Mapping::Spherical, Mapping::Asin] {
            let axes = mapping.footprint(&place);
            for (axis, duv) in axes.into_iter().zip(place.footprint) {
                let half = (dpdu * duv.x + dpdv * duv.y) * 0.5;
                let moved = |p: Vec3| mapping.st(&at(p, p.normalize()));
                let step = moved(place.p + half) - moved(place.p - half);
                assert!(
                    (step - axis).length() < 0.01 * axis.length(),
                    "{mapping:?}: {step} {axis}"
                );
            }
        }
    }
}
