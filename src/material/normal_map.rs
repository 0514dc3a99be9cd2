//! Maps that turn shading normals: normal maps and height maps.

use serde::Deserialize;

use super::Find;
use crate::{
    math::{Rgb, Vec2, Vec3},
    texture::{Color, Scalar, TextureId, TexturePoint, TextureSpace, Textures},
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
        let height = Scalar::compile(&self.height, Channel::R, find.color)?;
        let (texture, channel) = height.texture().ok_or_else(|| without_texture(self.height.span()))?;
        Ok(NormalMap::Heights(HeightMap {
            texture,
            channel: Some(channel),
            scale: self.distance.0,
        }))
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

    /// The normal of the surface with heights, relative to that without. It is unchanged where the
    /// surface has no texture coordinates.
    ///
    /// Heights lift the surface in the object's own space, before its transform: the tangents of the lifted surface in the
    /// scene are `dpdu + hu axis` and `dpdv + hv axis`, where `hu` and `hv` are the derivatives of the height. Their cross
    /// product has the direction of the normal.
    pub fn relief(&self, textures: &Textures<'_>, at: &TexturePoint, surface: &SurfaceOfHeights) -> Relief {
        let &SurfaceOfHeights { dpdu, dpdv, axis } = surface;
        let normal = dpdu.cross(dpdv);
        let area2 = normal.length_squared();
        if !(area2 > 0.0 && area2.is_finite()) {
            return Relief::NONE;
        }
        // A texel is the shortest length over which an interpolated picture has a slope; from afar it is the footprint.
        let texel = textures.texel(self.texture, at);
        let slope = |axis: Vec2| {
            let [a, b] = at.footprint.map(|f| f.dot(axis).abs());
            let step = texel.dot(axis).max(a).max(b);
            let height = |k: f32| self.height(textures, &at.moved(axis * (k * step)));
            (height(0.5) - height(-0.5)) / step
        };
        let gradient = (dpdv.cross(normal) * slope(Vec2::X) + normal.cross(dpdu) * slope(Vec2::Y)) * (1.0 / area2);
        let relief = match at.space {
            TextureSpace::Scene => Relief {
                slope: gradient,
                along: 1.0,
            },
            TextureSpace::Object => Relief {
                slope: gradient * (axis.dot(normal).abs() / area2.sqrt()),
                along: 1.0 + axis.dot(gradient),
            },
        };
        if relief.slope.is_finite() && relief.along.is_finite() {
            relief
        } else {
            Relief::NONE
        }
    }
}

/// A surface that heights lift, in the scene.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceOfHeights {
    /// The derivatives of the point with respect to u and v.
    pub dpdu: Vec3,
    pub dpdv: Vec3,
    /// The image of the unit normal in the object's own space. It is not perpendicular to the surface
    /// where a transform shears the object.
    pub axis: Vec3,
}

/// The normal of a lifted surface: it has the direction of the unit normal of the bare surface times `along`, minus `slope`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relief {
    /// A vector in the plane that touches the bare surface.
    pub slope: Vec3,
    /// It differs from 1 where a transform shears the object, and is negative where the lifted surface hangs over.
    pub along: f32,
}

impl Relief {
    /// The bare surface.
    pub const NONE: Self = Self {
        slope: Vec3::ZERO,
        along: 1.0,
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::{ColorConversion, DAffine3, DMat3, DVec3, Transform, WorkingSpace, hash},
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
    fn a_bump_has_the_normal_of_the_surface_that_is_lifted_and_then_transformed() {
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
        let transforms = [
            DMat3::IDENTITY,
            DMat3::from_diagonal(DVec3::new(1.0, 1.0, 4.0)),
            DMat3::from_diagonal(DVec3::new(4.0, 1.0, -1.0)),
            // A shear: the heights are aslant to the surface.
            DMat3::from_rotation_y(0.7) * DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0)) * DMat3::from_rotation_x(0.5),
        ];
        let transforms = transforms.map(|m| Transform::new(DAffine3::from_mat3(m)).expect("an inverse"));
        for i in 0..100 {
            let [x, y, z, w] = hash::pcg4d([i, 1, 2, 3]).map(hash::unit_f32);
            let mut check = |at: TexturePoint, scale: f32, expected: Vec3| {
                for t in &transforms {
                    let surface = SurfaceOfHeights {
                        dpdu: t.vector_to_world(at.dpdu),
                        dpdv: t.vector_to_world(at.dpdv),
                        axis: t.vector_to_world(at.n),
                    };
                    let Relief { slope, along } = bump(scale).relief(&textures, &at, &surface);
                    let bare = t.normal_to_world(at.n).normalize();
                    let found = (bare * along - slope).normalize();
                    let expected = t.normal_to_world(expected).normalize();
                    assert!((found - expected).length() < 0.015, "{i}, {t:?}: {found} {expected}");
                    steepest = steepest.max((found - bare).length());
                }
            };
            // A plane, whose parameters are no unit vectors.
            let at = TexturePoint {
                dpdu: Vec3::new(0.7, 0.0, 0.0),
                dpdv: Vec3::new(0.4, 1.6, 0.0),
                ..TexturePoint::new(Vec3::new(x, y, 0.0) * 9.0, Vec3::Z)
            };
            check(
                at,
                0.2,
                tessellated([Vec3::X, Vec3::Y], |d| at.p + d + Vec3::Z * height(at.p + d, 0.2)),
            );
            // A ball: the heights are small beside its radius.
            let n = (Vec3::new(y, z, w) * 2.0 - 1.0).normalize();
            let a = n.any_orthonormal_vector();
            let at = TexturePoint {
                dpdu: a * 0.3,
                dpdv: n.cross(a) * 2.0,
                curvature: 0.5,
                ..TexturePoint::new(n * 2.0, n)
            };
            let lifted = |d: Vec3| {
                let p = (at.p + d).normalize() * 2.0;
                p + p * 0.5 * height(p, 0.05)
            };
            check(at, 0.05, tessellated([a, n.cross(a)], lifted));
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
