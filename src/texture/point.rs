//! Points of surfaces, as textures see them.

use super::SharedFootprint;
use crate::math::{Rgb, Vec2, Vec3, Vec4};

/// The space of a point on a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureSpace {
    /// The object's own.
    Object,
    /// The scene's, around its origin: that of objects whose own space is the world.
    Scene,
}

/// A point of a surface in object space, so that a texture moves with its object.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint {
    /// Relative to `uv_origin`.
    pub uv: Vec2,
    /// Whole numbers; 0 unless the coordinates are far from 0.
    pub uv_origin: Vec2,
    pub p: Vec3,
    pub space: TextureSpace,
    /// Unit geometric normal, as authored.
    pub n: Vec3,
    /// The derivatives of `p` with respect to `uv`; zero where it has none.
    pub dpdu: Vec3,
    pub dpdv: Vec3,
    /// The curvature of the surface, in radians per metre; negative if it is concave on the normal's
    /// side.
    pub curvature: f32,
    /// The two axes of the footprint in `uv`, from end to end; zero for a point.
    pub footprint: [Vec2; 2],
    /// The same in the texels of some pictures.
    pub shared_footprint: SharedFootprint,
    /// Attributes that the vertices of a mesh give beside `uv`.
    pub vertex: VertexAttributes,
    /// The same point in the scene; unspecified where no texture reads it.
    pub scene: ScenePlace,
}

/// A point of a surface in the scene, around the scene's origin.
#[derive(Clone, Copy, Debug)]
pub struct ScenePlace {
    pub p: Vec3,
    /// Unit geometric normal, as authored.
    pub n: Vec3,
    /// The derivatives of `p` with respect to `uv`.
    pub dpdu: Vec3,
    pub dpdv: Vec3,
}

/// Attributes of a mesh at a point, interpolated between its vertices.
#[derive(Clone, Copy, Debug)]
pub struct VertexAttributes {
    /// Other texture coordinates.
    pub second_uv: Vec2,
    /// As [`TexturePoint::uv_origin`].
    pub second_uv_origin: Vec2,
    /// The change of `second_uv` along `u` and along `v`.
    pub second_per_uv: [Vec2; 2],
    pub color: Rgb,
    /// From 0 to 1.
    pub opacity: f32,
}

impl VertexAttributes {
    /// Those of a mesh that has none.
    pub const NONE: Self = Self {
        second_uv: Vec2::ZERO,
        second_uv_origin: Vec2::ZERO,
        second_per_uv: [Vec2::ZERO; 2],
        color: Rgb::WHITE,
        opacity: 1.0,
    };

    /// Those of a linear colour with its opacity.
    pub fn of_color(color: Vec4) -> Self {
        let [r, g, b, opacity] = color.to_array();
        Self {
            color: Rgb::new(r, g, b),
            opacity,
            ..Self::NONE
        }
    }
}

impl TexturePoint {
    /// The same point without a footprint.
    pub fn without_footprint(self) -> Self {
        Self {
            footprint: [Vec2::ZERO; 2],
            ..self
        }
    }

    /// A point without further data, in the object's own space.
    pub fn new(p: Vec3, n: Vec3) -> Self {
        Self {
            uv: Vec2::ZERO,
            uv_origin: Vec2::ZERO,
            p,
            space: TextureSpace::Object,
            n,
            dpdu: Vec3::ZERO,
            dpdv: Vec3::ZERO,
            curvature: 0.0,
            footprint: [Vec2::ZERO; 2],
            shared_footprint: SharedFootprint::NONE,
            vertex: VertexAttributes::NONE,
            scene: ScenePlace {
                p,
                n,
                dpdu: Vec3::ZERO,
                dpdv: Vec3::ZERO,
            },
        }
    }

    /// The texture coordinates, rounded to single precision.
    pub fn true_uv(&self) -> Vec2 {
        // An origin of 0 would turn -0 into 0.
        if self.uv_origin == Vec2::ZERO {
            self.uv
        } else {
            self.uv + self.uv_origin
        }
    }

    /// The point `duv` away on the plane that touches the surface.
    pub fn moved(&self, duv: Vec2) -> Self {
        let along = self.vertex.second_per_uv;
        Self {
            uv: self.uv + duv,
            p: self.p + self.dpdu * duv.x + self.dpdv * duv.y,
            vertex: VertexAttributes {
                second_uv: self.vertex.second_uv + along[0] * duv.x + along[1] * duv.y,
                ..self.vertex
            },
            scene: ScenePlace {
                p: self.scene.p + self.scene.dpdu * duv.x + self.scene.dpdv * duv.y,
                ..self.scene
            },
            ..*self
        }
    }

    /// The same for an object whose own space is the world; `p` is relative to the scene's origin.
    pub fn in_scene(p: Vec3, n: Vec3) -> Self {
        Self {
            space: TextureSpace::Scene,
            ..Self::new(p, n)
        }
    }
}
