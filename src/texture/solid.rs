//! Mappings to three coordinates: those of the object's own space, or of the world.

use serde::Deserialize;

use super::{TexturePoint, TextureSpace};
use crate::{
    math::{DMat3, DVec3, Vec2, Vec3},
    value::{Finite, List, OneOrEach, Point, SpaceScale},
};

/// The keys of a mapping in space.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolidDesc {
    pub scale: Option<OneOrEach<SpaceScale, 3>>,
    pub rotate: Option<List<Finite, 3>>,
    pub offset: Option<Point>,
}

/// The space whose coordinates a mapping reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SolidSpace {
    #[default]
    Object,
    World,
}

/// An affine map of a space to the coordinates of a texture.
#[derive(Clone, Copy, Debug)]
pub struct Solid {
    space: SolidSpace,
    axes: DMat3,
    /// The image of the origin of the object's own space or of the world.
    offset: DVec3,
    /// The image of the scene's origin.
    offset_in_scene: DVec3,
}

impl SolidDesc {
    /// Compiles the mapping for a scene around `origin`.
    pub fn compile(&self, space: SolidSpace, origin: DVec3) -> Solid {
        let scale = self.scale.map_or(DVec3::ONE, |s| DVec3::from_array(s.0.map(|v| v.0)));
        let axes = self.rotation() * DMat3::from_diagonal(scale);
        let offset = self.offset.map_or(DVec3::ZERO, |p| p.0);
        Solid {
            space,
            axes,
            offset,
            offset_in_scene: axes * origin + offset,
        }
    }

    /// The rotation of the space.
    pub(super) fn rotation(&self) -> DMat3 {
        let [x, y, z] = self.rotate.map_or([0.0; 3], |r| r.0.map(|v| v.0));
        turn(DVec3::Z, z) * turn(DVec3::Y, y) * turn(DVec3::X, x)
    }
}

/// The rotation about an axis of the space by an angle in degrees, exact for right angles.
fn turn(axis: DVec3, degrees: f32) -> DMat3 {
    let (sin, cos) = match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => libm::sincos(f64::from(degrees).to_radians()),
    };
    let along = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    let cross = DMat3::from_cols(axis.cross(DVec3::X), axis.cross(DVec3::Y), axis.cross(DVec3::Z));
    along + (DMat3::IDENTITY - along) * cos + cross * sin
}

impl Solid {
    /// The geometric normal of the surface at a point, in the space of the mapping.
    pub fn normal(&self, at: &TexturePoint) -> Vec3 {
        match self.space {
            SolidSpace::Object => at.n,
            SolidSpace::World => at.scene.n,
        }
    }

    /// The coordinates of a point.
    pub fn place(&self, at: &TexturePoint) -> DVec3 {
        let (p, offset) = match (self.space, at.space) {
            (SolidSpace::Object, TextureSpace::Object) => (at.p, self.offset),
            (SolidSpace::Object, TextureSpace::Scene) => (at.p, self.offset_in_scene),
            (SolidSpace::World, _) => (at.scene.p, self.offset_in_scene),
        };
        self.axes * p.as_dvec3() + offset
    }

    /// The change of the coordinates over the step `duv` of u and v.
    pub fn step(&self, at: &TexturePoint, duv: Vec2) -> Vec3 {
        let (dpdu, dpdv) = match self.space {
            SolidSpace::Object => (at.dpdu, at.dpdv),
            SolidSpace::World => (at.scene.dpdu, at.scene.dpdv),
        };
        (self.axes * (dpdu * duv.x + dpdv * duv.y).as_dvec3()).as_vec3()
    }

    /// Whether it reads the place of a point in the scene.
    pub fn reads_scene(&self) -> bool {
        self.space == SolidSpace::World
    }
}
