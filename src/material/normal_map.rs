//! Maps that turn shading normals: normal maps and height maps.

use crate::{
    math::{Rgb, Vec2, Vec3},
    texture::{Color, TextureId, TexturePoint, Textures},
    value::Channel,
};

/// A map that turns the shading normal.
#[derive(Clone, Copy, Debug)]
pub enum NormalMap {
    Normals(TangentNormals),
    Heights(HeightMap),
}

/// A normal map, as in glTF.
#[derive(Clone, Copy, Debug)]
pub struct TangentNormals {
    /// Colours from 0 to 1 encode components from -1 to 1.
    pub color: Color,
    /// Factor of x and y.
    pub scale: f32,
}

impl TangentNormals {
    /// The normal in the frame of tangent, bitangent and shading normal; need not be unit.
    pub fn normal(&self, textures: &Textures<'_>, at: &TexturePoint) -> Vec3 {
        let n = textures.color(&self.color, at) * 2.0 - Rgb::WHITE;
        Vec3::new(n.r * self.scale, n.g * self.scale, n.b)
    }
}

/// Heights above a surface, along its normal. The surface stays where it is, its shading normal is that of the surface with
/// these heights.
///
/// Source: Blinn, "Simulation of Wrinkled Surfaces", SIGGRAPH 1978, doi:10.1145/965139.507101.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightMap {
    pub texture: TextureId,
    /// `None` for the luminance.
    pub channel: Option<Channel>,
    /// The height where the texture is 1, in the object's own unit of length.
    pub scale: f32,
}

impl HeightMap {
    fn height(&self, textures: &Textures<'_>, at: &TexturePoint) -> f32 {
        self.scale
            * match self.channel {
                Some(channel) => textures.channel(self.texture, channel, at),
                None => textures.color(&Color::Texture(self.texture), at).luminance(),
            }
    }

    /// The slope of the heights: a vector in the plane of `dpdu` and `dpdv`, the derivatives of the surface in the scene. The
    /// normal with heights has the direction of the unit normal minus this vector. It is zero where the surface has no texture
    /// coordinates.
    pub fn gradient(&self, textures: &Textures<'_>, at: &TexturePoint, dpdu: Vec3, dpdv: Vec3) -> Vec3 {
        let normal = dpdu.cross(dpdv);
        let area2 = normal.length_squared();
        if !(area2 > 0.0 && area2.is_finite()) {
            return Vec3::ZERO;
        }
        // A texel is the shortest length over which an interpolated picture has a slope; from afar it is the footprint.
        let texel = textures.texel(self.texture, at);
        let slope = |axis: Vec2| {
            let [a, b] = at.footprint.map(|f| f.dot(axis).abs());
            let step = texel.dot(axis).max(a).max(b);
            let height = |k: f32| self.height(textures, &at.moved(axis * (k * step)));
            (height(0.5) - height(-0.5)) / step
        };
        // Heights grow with their object.
        let own_area = at.dpdu.cross(at.dpdv).length();
        let growth = if own_area > 0.0 {
            (area2.sqrt() / own_area).sqrt()
        } else {
            1.0
        };
        let gradient = (dpdv.cross(normal) * slope(Vec2::X) + normal.cross(dpdu) * slope(Vec2::Y)) * (growth / area2);
        if gradient.is_finite() { gradient } else { Vec3::ZERO }
    }
}
