//! Materials: the BSDF, the emission and the opacity of a surface, from colours and textures.

pub use medium::Medium;
pub use normal_map::{BumpDesc, HeightMap, NormalDesc, NormalMap, Relief, SurfaceOfHeights, TangentNormals};

pub use crate::math::Sidedness;
use crate::{
    bsdf::Bsdf,
    kind::kinds,
    math::{Rgb, Vec3, WorkingSpace},
    texture::{Color, FindColor, Scalar, TextureId, TexturePoint, Textures},
    value::{Channel, ColorSource, Problem, ScalarSource, Spanned},
};

pub mod emitter;
pub mod glass;
pub mod matte;
pub mod medium;
pub mod metal;
pub mod mirror;
pub mod mix;
pub mod normal_map;
pub mod phong;
pub mod principled;

/// An index into the scene's materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MaterialId(pub u32);

/// The terms of Whitted's illumination model at one point of a surface.
///
/// Source: Whitted, "An improved illumination model for shaded display", CACM 23(6), 1980,
/// doi:10.1145/358876.358882, with Phong's highlight, "Illumination for computer generated
/// pictures", CACM 18(6), 1975, doi:10.1145/360825.360839.
#[derive(Clone, Copy, Debug)]
pub struct WhittedTerms {
    /// Weight of the integrator's ambient light.
    pub ambient: Rgb,
    /// Weight of a light times max(n.l, 0).
    pub diffuse: Rgb,
    /// Weight of a light times max(r.v, 0)^shininess.
    pub specular: Rgb,
    pub shininess: f32,
    /// Weight of the reflected ray.
    pub reflect: Rgb,
    /// Weight of the refracted ray.
    pub transmit: Rgb,
    /// Index of refraction behind the surface, on the side that the normal points away from; it is
    /// 1 in front.
    pub ior: f32,
    pub fresnel_mode: FresnelMode,
    /// Whether the normal is flipped to face the viewer.
    pub two_sided: bool,
}

/// The split of light between reflection and transmission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FresnelMode {
    /// By the weights alone; total internal reflection adds the transmitted weight to the reflected
    /// one.
    Fixed,
    /// By Fresnel's equations, times the weights.
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

/// The way in which the surfaces of a material are shaded together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BatchKind {
    /// One by one.
    Alone,
    /// As [`Bsdf::Lambert`] with the normal of the surface, nearly everywhere.
    Diffuse,
    /// As [`Bsdf::OrenNayar`], [`Bsdf::Conductor`] or [`Bsdf::Layered`], where a block can hold it.
    RoughDiffuse,
    Metal,
    Layered,
}

impl BatchKind {
    /// The number of kinds.
    pub const COUNT: usize = Self::Layered as usize + 1;
}

/// The contract of every material.
pub trait MaterialKind {
    /// The terms of Whitted's model at a point.
    fn whitted_terms(&self, textures: &Textures<'_>, at: &TexturePoint) -> WhittedTerms;

    /// Converts all colours from Rec. 709 to a working space. Numbers that are no colours stay: roughness, indices of
    /// refraction, thin films.
    fn convert_colors(&mut self, space: WorkingSpace);

    /// The BSDF at a point, for all other integrators.
    fn bsdf(&self, textures: &Textures<'_>, at: &TexturePoint) -> Bsdf;

    /// Whether its BSDF may have more than one lobe, so that a random number selects one.
    fn has_lobes(&self) -> bool {
        true
    }

    /// The materials of which one is shaded in its place, if it is a mixture.
    fn mixture(&self) -> Option<&Mixture> {
        None
    }

    /// The emission, if there is any.
    fn emission(&self) -> Option<Emission> {
        None
    }

    /// The opacity at a point, from 0 to 1; the rest of the light passes straight through.
    fn opacity(&self, _textures: &Textures<'_>, _at: &TexturePoint) -> f32 {
        1.0
    }

    /// Whether nothing of it can be seen anywhere.
    fn is_invisible(&self, _textures: &Textures<'_>) -> bool {
        false
    }

    /// Whether [`MaterialKind::opacity`] is 1 everywhere.
    fn is_opaque(&self) -> bool {
        true
    }

    /// The texture whose alpha is the opacity, if there is one.
    fn opacity_texture(&self) -> Option<TextureId> {
        None
    }

    /// One of the textures that it reads at every point, if there are several.
    fn one_of_textures(&self) -> Option<TextureId> {
        None
    }

    /// The normal map of its own, if there is one. Any material may be given another one, see
    /// [`SceneShading::normal_map`](crate::scene::SceneShading::normal_map).
    fn normal_map(&self) -> Option<NormalMap> {
        None
    }

    /// The normal of a clear coat in the frame of the surface's tangent, bitangent and shading normal without a normal map, need
    /// not be unit; `None` where the coat has the normal of what is below it.
    fn coat_normal(&self, _textures: &Textures<'_>, _at: &TexturePoint) -> Option<Vec3> {
        None
    }

    /// The medium behind the surface; `None` where light does not enter.
    fn medium(&self) -> Option<Medium> {
        None
    }

    /// Whether light may pass the surface unbent where nothing but air is around it: whether
    /// [`BsdfKind::straight`](crate::bsdf::BsdfKind::straight) may be more than black.
    fn may_transmit_straight(&self) -> bool {
        false
    }

    /// Whether blocks of light samples hold its surfaces. Only glass and mirrors return `false`: where they need light samples,
    /// these are drawn one by one.
    fn is_lit(&self) -> bool {
        true
    }

    /// The way in which its surfaces are shaded together.
    fn batch_kind(&self) -> BatchKind {
        BatchKind::Alone
    }

    /// The largest reflectance of its colours; above 1 the material would gain energy.
    fn max_reflectance(&self, _textures: &Textures<'_>) -> f32 {
        0.0
    }

    /// Whether the material varies over the surface or depends on the tangent. Otherwise no texture
    /// coordinates are computed for it.
    fn is_spatially_varying(&self) -> bool {
        true
    }
}

/// A mixture of two materials.
#[derive(Clone, Copy, Debug)]
pub struct Mixture {
    pub materials: [MaterialId; 2],
    /// The share of the second, from 0 to 1.
    pub factor: Scalar,
}

impl Mixture {
    /// The material at a point that a random number in `[0, 1)` chooses, with the number that is left of it.
    pub fn choose(&self, textures: &Textures<'_>, at: &TexturePoint, number: f32) -> (MaterialId, f32) {
        let [a, b] = self.materials;
        let factor = textures.scalar(&self.factor, at).clamp(0.0, 1.0);
        let (material, left) = if number < factor {
            (b, number / factor)
        } else {
            (a, (number - factor) / (1.0 - factor))
        };
        (material, left.min(1.0 - 0.5 * f32::EPSILON))
    }
}

/// The light that a surface emits.
#[derive(Clone, Copy, Debug)]
pub struct Emission {
    /// Radiance in all directions, in W m^-2 sr^-1 after multiplication by `scale`.
    pub radiance: Color,
    pub scale: f32,
    pub sidedness: Sidedness,
    pub reach: EmissionReach,
}

/// The extent of what an emission lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmissionReach {
    /// Everything, as a lamp does.
    Everything,
    /// Nothing: it is the colour of an unlit surface, times that of its vertices, seen by the camera, in mirrors and through glass.
    Nothing,
}

impl Emission {
    /// The emitted radiance at a point, in W m^-2 sr^-1, on the front if `front_cos > 0` and else
    /// on the back.
    #[inline]
    pub fn radiance(&self, textures: &Textures<'_>, at: &TexturePoint, front_cos: f32) -> Rgb {
        if front_cos > 0.0 || self.sidedness == Sidedness::Both {
            let radiance = textures.color(&self.radiance, at) * self.scale;
            match self.reach {
                EmissionReach::Everything => radiance,
                EmissionReach::Nothing => radiance * at.vertex.color,
            }
        } else {
            Rgb::BLACK
        }
    }
}

/// The lookup of names when materials are compiled.
pub struct Find<'a> {
    pub color: &'a FindColor<'a>,
    /// The same of sources that hold directions along the tangents of a surface.
    pub directions: &'a FindColor<'a>,
    pub material: &'a dyn Fn(&Spanned<String>) -> Result<MaterialId, Problem>,
}

impl Find<'_> {
    /// The colour of a source.
    fn color(&self, source: &Spanned<ColorSource>) -> Result<Color, Problem> {
        (self.color)(source)
    }

    /// The directions of a source.
    fn directions(&self, source: &Spanned<ColorSource>) -> Result<Color, Problem> {
        (self.directions)(source)
    }

    /// Another material by its name.
    fn material(&self, name: &Spanned<String>) -> Result<MaterialId, Problem> {
        (self.material)(name)
    }
}

/// Compiles an optional scalar from 0 to 1; `default` where it is not given.
fn unit_scalar(
    source: Option<&Spanned<ScalarSource>>,
    default: f32,
    channel: Channel,
    find: &Find<'_>,
) -> Result<Scalar, Problem> {
    source.map_or(Ok(Scalar::Constant(default)), |source| {
        Scalar::compile_unit(source, channel, find.color)
    })
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
        "mix" => Mix(mix::Mix, mix::MixDesc),
    }
    described only {}
    compiled by fn compile(&self, find: &Find<'_>) -> Result<Material, Problem>;
    changed by {
        /// See [`MaterialKind::convert_colors`].
        fn convert_colors(&mut self, space: WorkingSpace);
    }
    /// See [`MaterialKind::whitted_terms`].
    fn whitted_terms(&self, textures: &Textures<'_>, at: &TexturePoint) -> WhittedTerms;
    /// See [`MaterialKind::bsdf`].
    fn bsdf(&self, textures: &Textures<'_>, at: &TexturePoint) -> Bsdf;
    /// See [`MaterialKind::mixture`].
    fn mixture(&self) -> Option<&Mixture>;
    /// See [`MaterialKind::emission`].
    fn emission(&self) -> Option<Emission>;
    /// See [`MaterialKind::has_lobes`].
    fn has_lobes(&self) -> bool;
    /// See [`MaterialKind::opacity`].
    fn opacity(&self, textures: &Textures<'_>, at: &TexturePoint) -> f32;
    /// See [`MaterialKind::is_invisible`].
    fn is_invisible(&self, textures: &Textures<'_>) -> bool;
    /// See [`MaterialKind::is_opaque`].
    fn is_opaque(&self) -> bool;
    /// See [`MaterialKind::opacity_texture`].
    fn opacity_texture(&self) -> Option<TextureId>;
    /// See [`MaterialKind::one_of_textures`].
    fn one_of_textures(&self) -> Option<TextureId>;
    /// See [`MaterialKind::normal_map`].
    fn normal_map(&self) -> Option<NormalMap>;
    /// See [`MaterialKind::coat_normal`].
    fn coat_normal(&self, textures: &Textures<'_>, at: &TexturePoint) -> Option<Vec3>;
    /// See [`MaterialKind::medium`].
    fn medium(&self) -> Option<Medium>;
    /// See [`MaterialKind::may_transmit_straight`].
    fn may_transmit_straight(&self) -> bool;
    /// See [`MaterialKind::is_lit`].
    fn is_lit(&self) -> bool;
    /// See [`MaterialKind::batch_kind`].
    fn batch_kind(&self) -> BatchKind;
    /// See [`MaterialKind::max_reflectance`].
    fn max_reflectance(&self, textures: &Textures<'_>) -> f32;
    /// See [`MaterialKind::is_spatially_varying`].
    fn is_spatially_varying(&self) -> bool;
}

impl MaterialDesc {
    /// The names of the materials that it mixes, if it is a mixture.
    pub fn mixed(&self) -> Option<[&Spanned<String>; 2]> {
        match self {
            Self::Mix(mix) => Some([&mix.a, &mix.b]),
            _ => None,
        }
    }
}
