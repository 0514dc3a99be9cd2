//! Maps that turn shading normals: normal maps and height maps.

use serde::Deserialize;

use super::Find;
use crate::{
    math::{Rgb, Vec2, Vec3},
    texture::{Color, Scalar, TextureId, TexturePoint, Textures},
    value::{Channel, ColorSource, Finite, Problem, ScalarSource, Spanned},
};

/// The key `bump` of a material.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BumpDesc {
    pub height: Spanned<ScalarSource>,
    pub distance: Finite,
}

/// The key `normal` of a material.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NormalDesc {
    pub map: Spanned<ColorSource>,
    pub scale: Option<Finite>,
}

impl BumpDesc {
    pub fn compile(&self, find: &Find<'_>) -> Result<NormalMap, Problem> {
        match Scalar::compile(&self.height, Channel::R, find.color)? {
            Scalar::Texture(texture, channel, _) | Scalar::Inverted(texture, channel, _) => {
                Ok(NormalMap::Heights(HeightMap {
                    texture,
                    channel: Some(channel),
                    scale: self.distance.0,
                }))
            }
            Scalar::Constant(_) => Err(without_texture(self.height.span())),
        }
    }
}

impl NormalDesc {
    pub fn compile(&self, find: &Find<'_>) -> Result<NormalMap, Problem> {
        let color = find.directions(&self.map)?;
        if color.is_constant() {
            return Err(without_texture(self.map.span()));
        }
        Ok(NormalMap::Normals(TangentNormals {
            color,
            scale: self.scale.map_or(1.0, |scale| scale.0),
        }))
    }
}

fn without_texture(span: std::ops::Range<usize>) -> Problem {
    Problem::at(span, "a number turns no normals").with_help("name a texture: \"texture.NAME\"")
}

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
        let n = textures.data(&self.color, at) * 2.0 - Rgb::WHITE;
        let slope = Vec2::new(n.r, n.g) * self.scale;
        textures.turned(&self.color, slope, at).extend(n.b)
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
                None => textures.data(&Color::Texture(self.texture), at).luminance(),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::{ColorConversion, DVec3, WorkingSpace, hash},
        texture::{
            Mapping, MappingDesc, Pattern, StTransform, Texture,
            constant::Constant,
            mapping::Ramp,
            noise::{Noise, NoiseChannels, NoiseForm},
            two_colors::TwoColors,
        },
    };

    /// The normal that a map of one colour, which leans by (0.6, 0, 0.8), tells on a surface whose u runs along x.
    fn leaning(mapping: Mapping, transform: StTransform) -> Vec3 {
        let color = Rgb::new(0.8, 0.5, 0.9);
        let texture = Texture {
            transform,
            // Normals are no colours.
            colors: ColorConversion::new(Default::default(), WorkingSpace::AcesCg),
            ..Texture::new(mapping, Pattern::Constant(Constant { color }))
        };
        let textures = Textures {
            textures: &[texture],
            bitmaps: &[],
        };
        let at = TexturePoint {
            dpdu: Vec3::X * 2.0,
            dpdv: Vec3::Y * 0.5,
            ..TexturePoint::new(Vec3::ZERO, Vec3::Z)
        };
        let color = Color::Texture(TextureId(0));
        TangentNormals { color, scale: 1.0 }.normal(&textures, &at)
    }

    #[test]
    fn normals_turn_with_the_picture_that_holds_them() {
        let close = |found: Vec3, expected: [f32; 3]| {
            assert!((found - Vec3::from_array(expected)).length() < 1e-6, "{found}");
        };
        let turned = |degrees, scale| leaning(Mapping::Uv, StTransform::new(Vec2::ZERO, degrees, scale));
        close(turned(0.0, Vec2::ONE), [0.6, 0.0, 0.8]);
        close(turned(0.0, Vec2::new(3.0, 1.0)), [0.6, 0.0, 0.8]);
        // s grows against v.
        close(turned(90.0, Vec2::ONE), [0.0, -0.6, 0.8]);
        close(turned(180.0, Vec2::ONE), [-0.6, 0.0, 0.8]);
        close(turned(0.0, Vec2::new(-1.0, 1.0)), [-0.6, 0.0, 0.8]);
        close(turned(0.0, Vec2::new(1.0, -1.0)), [0.6, 0.0, 0.8]);
        // s grows along four times u and once v.
        close(turned(-45.0, Vec2::new(1.0, 4.0)), {
            let along = Vec2::new(4.0 * 2.0, 0.5).normalize() * 0.6;
            [along.x, along.y, 0.8]
        });
    }

    /// The normal at `p` of the surface `lifted` along the tangents `a` and `b`, by short differences.
    fn tessellated([a, b]: [Vec3; 2], lifted: impl Fn(Vec3) -> Vec3) -> Vec3 {
        const STEP: f32 = 2e-3;
        let along = |d: Vec3| lifted(d * STEP) - lifted(d * -STEP);
        along(a).cross(along(b)).normalize()
    }

    #[test]
    fn a_bump_has_the_normal_of_the_lifted_surface() {
        let noise = Noise {
            colors: TwoColors([Rgb::BLACK, Rgb::WHITE]),
            form: NoiseForm::Fbm,
            scale: 4.0,
            octaves: 2,
            lacunarity: 2.0,
            gain: 0.5,
            seed: 3,
            channels: NoiseChannels::Gray,
        };
        let solid = MappingDesc::Object(Default::default())
            .compile(DVec3::ZERO)
            .expect("a mapping");
        let textures = Textures {
            textures: &[Texture::new(solid, Pattern::Noise(noise))],
            bitmaps: &[],
        };
        let bump = |scale| HeightMap {
            texture: TextureId(0),
            channel: Some(Channel::R),
            scale,
        };
        let height =
            |p: Vec3, scale: f32| textures.channel(TextureId(0), Channel::R, &TexturePoint::new(p, Vec3::Z)) * scale;
        let mut steepest: f32 = 0.0;
        for i in 0..100 {
            let [x, y, z, w] = hash::pcg4d([i, 1, 2, 3]).map(hash::unit_f32);
            let check = |at: TexturePoint, scale: f32, expected: Vec3, bound: f32| {
                let gradient = bump(scale).gradient(&textures, &at, at.dpdu, at.dpdv);
                let found = (at.n - gradient).normalize();
                assert!((found - expected).length() < bound, "{i}: {found} {expected}");
                (found - at.n).length()
            };
            // A plane, whose parameters are no unit vectors.
            let at = TexturePoint {
                dpdu: Vec3::new(0.7, 0.0, 0.0),
                dpdv: Vec3::new(0.4, 1.6, 0.0),
                ..TexturePoint::new(Vec3::new(x, y, 0.0) * 9.0, Vec3::Z)
            };
            let expected = tessellated([Vec3::X, Vec3::Y], |d| at.p + d + Vec3::Z * height(at.p + d, 0.2));
            steepest = steepest.max(check(at, 0.2, expected, 0.01));
            // A ball: the heights are small beside its radius.
            let n = (Vec3::new(y, z, w) * 2.0 - 1.0).normalize();
            let a = n.any_orthonormal_vector();
            let at = TexturePoint {
                dpdu: a * 0.3,
                dpdv: n.cross(a) * 2.0,
                curvature: 0.5,
                ..TexturePoint::new(n * 2.0, n)
            };
            let expected = tessellated([a, n.cross(a)], |d| {
                let p = (at.p + d).normalize() * 2.0;
                p + p * 0.5 * height(p, 0.05)
            });
            check(at, 0.05, expected, 0.01);
        }
        assert!(steepest > 0.2, "the heights are flat: {steepest}");
    }

    #[test]
    fn normals_follow_the_mapping_of_their_picture() {
        let ramp = |axis, to| Ramp::new(axis, [0.0, to], DVec3::ZERO);
        let planar = |s, t| leaning(Mapping::Planar { s, t }, StTransform::IDENTITY);
        let close = |found: Vec3, expected: Vec3| assert!((found - expected).length() < 1e-6, "{found}");
        close(planar(ramp(0, 5.0), ramp(1, 5.0)), Vec3::new(0.6, 0.0, 0.8));
        close(planar(ramp(0, -5.0), ramp(1, 5.0)), Vec3::new(-0.6, 0.0, 0.8));
        close(planar(ramp(1, 5.0), ramp(0, 5.0)), Vec3::new(0.0, 0.6, 0.8));
        // Of a picture that does not lie on the surface nobody can say.
        close(planar(ramp(2, 5.0), ramp(2, 5.0)), Vec3::new(0.6, 0.0, 0.8));
    }
}
