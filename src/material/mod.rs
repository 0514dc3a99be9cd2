//! Materials: what a surface does with light, by the colours of a place on it.

pub use crate::math::Sidedness;
use crate::{
    bsdf::Bsdf,
    kind::kinds,
    math::{Rgb, Vec3},
    texture::{Color, Scalar, TexturePoint, Textures},
    value::{Channel, ColorSource, Problem, ScalarSource, Spanned},
};

pub mod emitter;
pub mod glass;
pub mod matte;
pub mod medium;
pub mod metal;
pub mod mirror;
pub mod phong;
pub mod principled;

/// An index into the scene's materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MaterialId(pub u32);

/// The terms of Whitted's illumination model at one place of a surface.
///
/// Source: Whitted, "An improved illumination model for shaded display", CACM 23(6), 1980, doi:10.1145/358876.358882,
/// with Phong's highlight, "Illumination for computer generated pictures", CACM 18(6), 1975, doi:10.1145/360825.360839.
#[derive(Clone, Copy, Debug)]
pub struct WhittedTerms {
    /// Weight of the integrator's ambient light.
    pub ambient: Rgb,
    /// Weight of a light times max(n.l, 0).
    pub diffuse: Rgb,
    /// Weight of a light times max(r.v, 0)^shininess.
    pub specular: Rgb,
    pub shininess: f32,
    /// Weight of what arrives along the mirror direction.
    pub reflect: Rgb,
    /// Weight of what arrives through the surface.
    pub transmit: Rgb,
    /// Index of refraction behind the surface, where its normal does not point; 1 is in front.
    pub ior: f32,
    pub fresnel_mode: FresnelMode,
    /// Whether the normal is turned towards the viewer first.
    pub two_sided: bool,
}

/// How light is shared out between reflection and transmission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FresnelMode {
    /// As the weights say; what cannot pass is reflected.
    Fixed,
    /// As Fresnel's equations say, times the weights.
    Fresnel,
}

impl Default for WhittedTerms {
    /// Black, seen from both sides.
    fn default() -> Self {
        Self {
            ambient: Rgb::BLACK,
            diffuse: Rgb::BLACK,
            specular: Rgb::BLACK,
            shininess: 0.0,
            reflect: Rgb::BLACK,
            transmit: Rgb::BLACK,
            ior: 1.0,
            fresnel_mode: FresnelMode::Fixed,
            two_sided: true,
        }
    }
}

/// The contract of every material.
pub trait MaterialKind {
    /// Its terms at a place, for Whitted's integrator.
    fn whitted_terms(&self, textures: &Textures<'_>, at: &TexturePoint) -> WhittedTerms;

    /// How it scatters light at a place, for all others.
    fn bsdf(&self, textures: &Textures<'_>, at: &TexturePoint) -> Bsdf;

    /// What it shines with of its own, if it does.
    fn emission(&self) -> Option<Emission> {
        None
    }

    /// The part of the light that it stops at a place, from 0 to 1: what is left passes straight on.
    fn opacity(&self, _textures: &Textures<'_>, _at: &TexturePoint) -> f32 {
        1.0
    }

    /// Whether [`MaterialKind::opacity`] is 1 everywhere.
    fn is_opaque(&self) -> bool {
        true
    }

    /// What tells its normals, where that is not the shape.
    fn normal_map(&self) -> Option<NormalMap> {
        None
    }

    /// How strongly the medium behind the surface absorbs, in m^-1 (Beer's law); black where there is none.
    fn absorption(&self) -> Rgb {
        Rgb::BLACK
    }

    /// The brightest of its colours that tell a part of the light; above 1 more would leave than arrives.
    fn max_reflectance(&self, _textures: &Textures<'_>) -> f32 {
        0.0
    }

    /// Whether it may differ from place to place or with the tangent: where it does not, no place on textures is found for it.
    fn is_spatially_varying(&self) -> bool {
        true
    }
}

/// Light of a surface's own.
#[derive(Clone, Copy, Debug)]
pub struct Emission {
    /// What leaves the front in all directions alike, in W m^-2 sr^-1, once it is multiplied by `scale`.
    pub radiance: Color,
    pub scale: f32,
    pub sidedness: Sidedness,
}

impl Emission {
    /// The radiance at a place, in W m^-2 sr^-1, towards the side that is in front if `front_cos > 0`.
    #[inline]
    pub fn radiance(&self, textures: &Textures<'_>, at: &TexturePoint, front_cos: f32) -> Rgb {
        if front_cos > 0.0 || self.sidedness == Sidedness::Both {
            textures.color(&self.radiance, at) * self.scale
        } else {
            Rgb::BLACK
        }
    }
}

/// Normals from a texture, as glTF has them.
#[derive(Clone, Copy, Debug)]
pub struct NormalMap {
    /// 0 to 1 stands for -1 to 1.
    pub color: Color,
    /// Of x and y.
    pub scale: f32,
}

impl NormalMap {
    /// In the frame of tangent, bitangent and shading normal; need not be unit.
    pub fn normal(&self, textures: &Textures<'_>, at: &TexturePoint) -> Vec3 {
        let n = textures.color(&self.color, at) * 2.0 - Rgb::WHITE;
        Vec3::new(n.r * self.scale, n.g * self.scale, n.b)
    }
}

/// What a material's compilation asks of the scene: the colour that a source names.
pub type FindColor<'a> = dyn Fn(&Spanned<ColorSource>) -> Result<Color, Problem> + 'a;

/// The number that a source names; of a texture the channel `default` unless one is said.
fn scalar(source: &Spanned<ScalarSource>, default_channel: Channel, find: &FindColor<'_>) -> Result<Scalar, Problem> {
    match source.get_ref() {
        ScalarSource::Constant(v) => Ok(Scalar::Constant(*v)),
        ScalarSource::Texture { name, channel } => {
            match find(&Spanned::new(source.span(), ColorSource::Texture(name.clone())))? {
                Color::Constant(c) => Ok(Scalar::Constant(c.r)),
                Color::Texture(id) | Color::Tinted(id, _) => {
                    Ok(Scalar::Texture(id, channel.unwrap_or(default_channel), 1.0))
                }
            }
        }
    }
}

/// The same for a number from 0 to 1, which is `unsaid` where none is given.
fn unit_scalar(
    source: Option<&Spanned<ScalarSource>>,
    default: f32,
    channel: Channel,
    find: &FindColor<'_>,
) -> Result<Scalar, Problem> {
    let Some(source) = source else {
        return Ok(Scalar::Constant(default));
    };
    match source.get_ref() {
        ScalarSource::Constant(v) if *v > 1.0 => {
            let message = format!("expected a number from 0 to 1, found {v}");
            Err(Problem::at(source.span(), message))
        }
        _ => scalar(source, channel, find),
    }
}

kinds! {
    /// A material, flat and without pointers.
    enum Material / MaterialDesc {
        "phong" => Phong(phong::Phong, phong::PhongDesc),
        "matte" => Matte(matte::Matte, matte::MatteDesc),
        "glass" => Glass(glass::Glass, glass::GlassDesc),
        "mirror" => Mirror(mirror::Mirror, mirror::MirrorDesc),
        "emitter" => Emitter(emitter::Emitter, emitter::EmitterDesc),
        "metal" => Metal(metal::Metal, metal::MetalDesc),
        "principled" => Principled(principled::Principled, principled::PrincipledDesc),
    }
    described only {}
    compiled by fn compile(&self, find: &FindColor<'_>) -> Result<Material, Problem>;
    /// See [`MaterialKind::whitted_terms`].
    fn whitted_terms(&self, textures: &Textures<'_>, at: &TexturePoint) -> WhittedTerms;
    /// See [`MaterialKind::bsdf`].
    fn bsdf(&self, textures: &Textures<'_>, at: &TexturePoint) -> Bsdf;
    /// See [`MaterialKind::emission`].
    fn emission(&self) -> Option<Emission>;
    /// See [`MaterialKind::opacity`].
    fn opacity(&self, textures: &Textures<'_>, at: &TexturePoint) -> f32;
    /// See [`MaterialKind::is_opaque`].
    fn is_opaque(&self) -> bool;
    /// See [`MaterialKind::normal_map`].
    fn normal_map(&self) -> Option<NormalMap>;
    /// See [`MaterialKind::absorption`].
    fn absorption(&self) -> Rgb;
    /// See [`MaterialKind::max_reflectance`].
    fn max_reflectance(&self, textures: &Textures<'_>) -> f32;
    /// See [`MaterialKind::is_spatially_varying`].
    fn is_spatially_varying(&self) -> bool;
}
