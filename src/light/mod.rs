//! Analytic lights, area lights and environments.
//!
//! 1 cd is 1 W/sr and 1 lux is 1 W/m^2 per channel: a luminous efficacy is applied to IES files and, by choice, to models alone.

use serde::Deserialize;

use crate::{
    kind::kinds,
    math::{Aabb, Rgb, Vec2, Vec3, WorkingSpace},
    shape::{Shape, ShapeHit},
    value::Problem,
};

/// The luminous efficacy of green light, in lm W^-1: that of IES files and of Blender's exporter.
pub const LUMENS_PER_WATT: u32 = 683;

mod aim;
pub mod area;
mod area_block;
mod ball;
mod beam;
pub mod bounds;
pub mod disk;
pub mod environment;
mod find;
mod focus;
pub mod gradient;
pub mod lamp;
mod light_block;
mod picture;
pub mod point;
pub mod profile;
pub mod rect;
pub mod sky;
pub mod sphere;
pub mod spot;
pub mod sun;
mod tables;
mod temperature;
pub mod tree;
pub mod tube;

pub use crate::math::Sidedness;
pub use area_block::AreaBlock;
pub use beam::IesFile;
pub use bounds::{LightBounds, OrientationCone};
pub use find::LightFind;
pub use lamp::Sight;
pub use light_block::LightBlock;
pub use picture::{Picture, PictureMap};
pub use profile::{Profile, ProfileId};
pub use tables::LightTables;

/// Light that arrives at a point from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit direction towards the light.
    pub wi: Vec3,
    /// Distance to the light along `wi`, in m; infinite for a sun.
    pub distance: f32,
    /// The radiance, in W m^-2 sr^-1; for a light without size the irradiance on a surface that faces it, in W m^-2.
    pub li: Rgb,
    /// Density of `wi` in sr^-1; `None` for a light without size, which has a single direction.
    pub pdf: Option<f32>,
}

/// The contract of every light.
pub trait LightKind {
    /// Samples a direction from which light arrives at `from`, by two uniform numbers in `[0, 1)`;
    /// `None` if no light arrives. `tables` are those of the scene.
    fn sample(&self, tables: &LightTables<'_>, from: Vec3, u: Vec2) -> Option<LightSample>;

    /// The bounds of the light; `None` if its irradiance does not decrease with distance.
    fn bounds(&self, tables: &LightTables<'_>) -> Option<LightBounds>;

    /// Whether the light can illuminate a surface at `p` with the unit normal `n` (zero: any
    /// normal) if it is not occluded.
    fn reaches(&self, p: Vec3, n: Vec3) -> bool;

    /// The strength of the light, with its unit.
    fn strength(&self) -> (Rgb, &'static str);

    /// Converts all colours from Rec. 709 to a working space.
    fn convert_colors(&mut self, space: WorkingSpace);

    /// Its picture, if it has one.
    fn picture(&self) -> Option<&Picture> {
        None
    }

    /// Whether [`LightKind::sample`] reads its numbers.
    fn has_size(&self) -> bool {
        false
    }

    /// The surface that rays find, and the rays that find it; `None` for a light at infinity and for one without size.
    fn surface(&self) -> Option<(Shape, Sight)> {
        None
    }

    /// The radiance, in W m^-2 sr^-1, that arrives at `from` along the ray of the unit direction `w` that has this hit on the
    /// surface, and the density with which [`LightKind::sample`] samples `w`, in sr^-1.
    fn seen(&self, _tables: &LightTables<'_>, _from: Vec3, _w: Vec3, _hit: &ShapeHit) -> (Rgb, f32) {
        (Rgb::BLACK, 0.0)
    }

    /// Sets the emitter of a block's lane, if a block can hold the light. Returns whether it can.
    fn put_in_block(&self, _lane: usize, _block: &mut AreaBlock) -> bool {
        false
    }

    /// Whether the camera sees the disk of [`LightKind::radiance_towards`].
    fn is_seen_by_camera(&self) -> bool {
        false
    }

    /// The radiance that arrives from infinity against the unit direction `w`, in W m^-2 sr^-1, and the density with which
    /// [`LightKind::sample`] samples `w`, in sr^-1; `None` outside of the disk and for a light without size.
    fn radiance_towards(&self, _w: Vec3) -> Option<(Rgb, f32)> {
        None
    }
}

kinds! {
    /// A light, flat and without pointers.
    enum Light / LightDesc {
        "point" => Point(point::PointLight, point::PointDesc),
        "spot" => Spot(spot::SpotLight, spot::SpotDesc),
        "sun" => Sun(sun::SunLight, sun::SunDesc),
        "rect" => Rect(lamp::Lamp, rect::RectDesc),
        "disk" => Disk(lamp::Lamp, disk::DiskDesc),
        "sphere" => Sphere(lamp::Lamp, sphere::SphereDesc),
        "tube" => Tube(lamp::Lamp, tube::TubeDesc),
    }
    described only {}
    compiled by fn compile(&self, find: &LightFind<'_>) -> Result<Light, Problem>;
    described by {
        /// The file of its profile, if it has one.
        fn ies(&self) -> Option<IesFile<'_>>;
    }
    changed by {
        /// See [`LightKind::convert_colors`].
        fn convert_colors(&mut self, space: WorkingSpace);
    }
    /// See [`LightKind::sample`].
    fn sample(&self, tables: &LightTables<'_>, from: Vec3, u: Vec2) -> Option<LightSample>;
    /// See [`LightKind::picture`].
    fn picture(&self) -> Option<&Picture>;
    /// See [`LightKind::bounds`].
    fn bounds(&self, tables: &LightTables<'_>) -> Option<LightBounds>;
    /// See [`LightKind::reaches`].
    fn reaches(&self, p: Vec3, n: Vec3) -> bool;
    /// See [`LightKind::strength`].
    fn strength(&self) -> (Rgb, &'static str);
    /// See [`LightKind::has_size`].
    fn has_size(&self) -> bool;
    /// See [`LightKind::surface`].
    fn surface(&self) -> Option<(Shape, Sight)>;
    /// See [`LightKind::seen`].
    fn seen(&self, tables: &LightTables<'_>, from: Vec3, w: Vec3, hit: &ShapeHit) -> (Rgb, f32);
    /// See [`LightKind::put_in_block`].
    fn put_in_block(&self, lane: usize, block: &mut AreaBlock) -> bool;
    /// See [`LightKind::radiance_towards`].
    fn radiance_towards(&self, w: Vec3) -> Option<(Rgb, f32)>;
    /// See [`LightKind::is_seen_by_camera`].
    fn is_seen_by_camera(&self) -> bool;
}

/// The decrease of the irradiance with distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Falloff {
    /// Physical: intensity / distance^2.
    #[default]
    InverseSquare,
    /// No decrease, as in the first ray tracers.
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

/// The bounds of a point light; `None` without falloff.
fn point_bounds(position: Vec3, falloff: Falloff, intensity: Rgb, directions: OrientationCone) -> Option<LightBounds> {
    (falloff == Falloff::InverseSquare).then(|| LightBounds {
        bounds: Aabb::from_points([position]),
        directions,
        power: intensity.mean(),
    })
}

/// Whether a surface with the unit normal `n` (zero: any normal) faces the direction `to`, which
/// need not be unit. Conservative about rounding.
fn is_facing(n: Vec3, to: Vec3) -> bool {
    n.dot(to) >= -1e-4 * to.length()
}

/// Samples a light at a point; shared by [`point`] and [`spot`].
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
