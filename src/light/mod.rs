//! Lights: where radiance comes from that no ray meets by chance.
//!
//! 1 cd is 1 W/sr and 1 lux is 1 W/m^2 per channel: no luminous efficacy enters.

use serde::Deserialize;

use crate::{
    kind::kinds,
    math::{Aabb, Rgb, Vec2, Vec3},
    value::Problem,
};

pub mod area;
pub mod bounds;
pub mod environment;
pub mod point;
pub mod spot;
pub mod sun;
pub mod tree;

pub use crate::math::Sidedness;
pub use bounds::{LightBounds, OrientationCone};

/// Light that arrives at a place from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit direction towards the light.
    pub wi: Vec3,
    /// Where the light is, in m along `wi`; infinite for a sun.
    pub distance: f32,
    /// For a light without size: the irradiance on a surface that faces it, in W m^-2. Otherwise the radiance, in
    /// W m^-2 sr^-1.
    pub li: Rgb,
    /// Density of `wi` in sr^-1; `None` for a light without size, which has but one direction.
    pub pdf: Option<f32>,
}

/// The contract of every light.
pub trait LightKind {
    /// A direction from which light arrives at `from`, by two uniform numbers in `[0, 1)`; `None` where none does.
    fn sample(&self, from: Vec3, u: Vec2) -> Option<LightSample>;

    /// Where it is and where it shines to; `None` where its light does not thin out with distance.
    fn bounds(&self) -> Option<LightBounds>;

    /// Whether it may light a surface at `p` of unit normal `n` (zero: of any), if nothing is in the way.
    fn reaches(&self, p: Vec3, n: Vec3) -> bool;
}

kinds! {
    /// A light, flat and without pointers.
    enum Light / LightDesc {
        "point" => Point(point::PointLight, point::PointDesc),
        "spot" => Spot(spot::SpotLight, spot::SpotDesc),
        "sun" => Sun(sun::SunLight, sun::SunDesc),
    }
    described only {}
    compiled by fn compile(&self) -> Result<Light, Problem>;
    /// See [`LightKind::sample`].
    fn sample(&self, from: Vec3, u: Vec2) -> Option<LightSample>;
    /// See [`LightKind::bounds`].
    fn bounds(&self) -> Option<LightBounds>;
    /// See [`LightKind::reaches`].
    fn reaches(&self, p: Vec3, n: Vec3) -> bool;
}

/// How light thins out with distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Falloff {
    /// As real light does: intensity / distance^2.
    #[default]
    InverseSquare,
    /// Not at all, as in the first ray tracers.
    None,
}

impl Falloff {
    /// The irradiance per intensity at `distance_squared`, in m^-2.
    fn factor(self, distance_squared: f32) -> f32 {
        match self {
            Self::InverseSquare => 1.0 / distance_squared,
            Self::None => 1.0,
        }
    }
}

/// The bounds of a light at a point, for light that thins out.
fn point_bounds(position: Vec3, falloff: Falloff, intensity: Rgb, directions: OrientationCone) -> Option<LightBounds> {
    (falloff == Falloff::InverseSquare).then(|| LightBounds {
        bounds: Aabb::from_points([position]),
        directions,
        power: intensity.mean(),
    })
}

/// Whether a surface at `p` of unit normal `n` (zero: of any) sees the direction `to`, which need not be unit; yes where
/// rounding leaves a doubt.
fn is_facing(n: Vec3, to: Vec3) -> bool {
    n.dot(to) >= -1e-4 * to.length()
}

/// Light from a point: what [`point`] and [`spot`] share.
fn sample_point(position: Vec3, from: Vec3, falloff: Falloff, intensity: impl Fn(Vec3) -> Rgb) -> Option<LightSample> {
    let to = position - from;
    let d2 = to.length_squared();
    if !(d2 > 0.0 && d2.is_finite()) {
        return None;
    }
    let distance = d2.sqrt();
    let wi = to / distance;
    let li = intensity(wi) * falloff.factor(d2);
    (!li.is_black()).then_some(LightSample {
        wi,
        distance,
        li,
        pdf: None,
    })
}
