//! A physically based material for most surfaces: glTF's metallic-roughness model with its extensions.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `base_color` | colour: diffuse colour, metal's reflectance at normal incidence, tint of transmitted light | | 0.8 |
//! | `metallic` | amount (b): how much of the surface is metal | | 0 |
//! | `roughness` | amount (g); its square is GGX's alpha | | 0.5 |
//! | `ior` | index of refraction of the inside, above 0 | | 1.5 |
//! | `specular` | amount (a): strength of the reflection above the diffuse base | | 1 |
//! | `specular_color` | colour: tint of that reflection at normal incidence | | 1 |
//! | `transmission` | amount (r): how much of what is not metal is transparent | | 0 |
//! | `diffuse_transmission` | amount (a): how much of the diffuse light leaves on the other side, as through a leaf or paper | | 0 |
//! | `diffuse_transmission_color` | colour of that light | | 1 |
//! | `thickness` | number of at least 0: above 0 the surface bounds a volume, which refracts | m | 0 |
//! | `dispersion` | number of at least 0, of a volume: 20 over the Abbe number, 0.33 for crown glass and 0.36 for diamond | | 0 |
//! | `attenuation_color` | `[r, g, b]`: the colour of white light after `attenuation_distance` in the volume | | 1 |
//! | `attenuation_distance` | number above 0; also makes the surface bound a volume | m | no absorption |
//! | `priority` | whole number: where bodies overlap, the one of the highest priority fills the place (see `glass`) | | 0 |
//! | `clearcoat`, `clearcoat_roughness` | amounts (r, g): a clear coat of index 1.5 | | 0 |
//! | `clearcoat_normal` | `"texture.NAME"`, raw: the coat's own normal map; without it the coat has the normal of the bare surface | | |
//! | `clearcoat_normal_scale` | strength of that normal map | | 1 |
//! | `sheen_color` | colour: the sheen of cloth and dust at grazing angles | | 0 |
//! | `sheen_roughness` | amount (a); the least is 0.15 | | 0 |
//! | `iridescence` | amount (r): how much is covered by a thin film | | 0 |
//! | `iridescence_ior` | index of refraction of the film, above 0 | | 1.3 |
//! | `iridescence_thickness` | thickness of the film, at least 0 | nm | 400 |
//! | `anisotropy` | amount (b): stretches highlights along the tangent | | 0 |
//! | `anisotropy_direction` | `"texture.NAME"`, raw: red and green, from -1 at 0 to 1 at 1, are the direction of the stretching along tangent and bitangent | | the tangent |
//! | `anisotropy_rotation` | rotation of that direction, from the tangent to the bitangent | degrees | 0 |
//! | `emissive` | colour: emitted radiance; its objects are area lights | W m^-2 sr^-1 | 0 |
//! | `emissive_strength` | factor of at least 0 | | 1 |
//! | `normal` | `"texture.NAME"`, raw: a tangent-space normal map | | |
//! | `normal_scale` | strength of the normal map | | 1 |
//! | `opacity` | amount (a), of the surface as a whole | | 1 |
//! | `alpha` | how `opacity` counts: `"opaque"` ignores it, `"mask"` cuts out, `"blend"` is transparent by degrees | | `"blend"` |
//! | `alpha_cutoff` | number from 0 to 1, for `"mask"`: less opacity than this is a hole | | 0.5 |
//! | `two_sided` | whether the back emits as well | | false |
//!
//! A colour is a number, `[r, g, b]` or `"texture.NAME"`. An amount is a number from 0 to 1, `"texture.NAME"` (the channel
//! in brackets) or a channel of a texture, `"texture.NAME.r"`.
//!
//! ```toml
//! [material.car]
//! principled = { base_color = [0.5, 0.02, 0.02], roughness = 0.4, metallic = 0.3, clearcoat = 1, clearcoat_roughness = 0.05 }
//!
//! [material.bubble]
//! principled = { base_color = 1, transmission = 1, roughness = 0, iridescence = 1 }
//!
//! [material.worn]
//! principled = { base_color = "texture.paint", roughness = "texture.wear", metallic = "texture.wear.r" }
//!
//! [texture.paint]
//! checker = { a = [0.6, 0.1, 0.1], b = [0.9, 0.9, 0.9], scale = 4 }
//!
//! [texture.wear]
//! checker = { a = [0, 0.2, 0], b = [1, 0.6, 0] }
//! ```
//!
//! The layers from the top are sheen, clear coat, and a mix of metal, diffuse base and glass. Each layer dims those below by
//! what it reflects: a white material loses less than 2 % of the light at any roughness and angle, or 16 % with `iridescence`,
//! and gains none (up to an index of 4). Both sides scatter light.
//!
//! Without `thickness` and `attenuation_distance` the surface is a thin sheet, and transmitted light goes straight through.
//! Highlights are not stretched on surfaces that refract light into a volume: the roughness has the same mean square alpha.
//! Dispersive volumes refract red, green and blue in three directions: a path follows one of them, so they need more samples.
//! Radiance is not scaled by the square of the index of refraction. The coat does not dim emitted light. `normal` turns what
//! lies below the coat alone.
//!
//! The `whitted` integrator shows the diffuse base, a mirror with the reflectance at normal incidence, and smooth glass. The
//! rougher a mirror is, the more of it is diffuse.
//!
//! Source: Khronos Group, "glTF 2.0 Specification", appendix B, and its KHR_materials extensions. One thing differs: the
//! sheen lies above the coat.
//!
//! # Implementation
//!
//! The layers are in [`crate::bsdf::layered`], [`crate::bsdf::thin_film`] and [`crate::bsdf::sheen`].

mod desc;
mod textures;

pub use desc::{AlphaModeDesc, PrincipledDesc};

use std::f32::consts::FRAC_1_PI;

use super::{
    BatchKind, Emission, EmissionReach, FresnelMode, HeightMap, MaterialKind, Medium, NormalMap, Sidedness,
    TangentNormals, WhittedTerms, medium,
};
use crate::{
    bsdf::{
        Bsdf, is_equal_ior,
        layered::{Boundary, Layers},
        microfacet::{Facets, Ggx},
        thin_film::ThinFilm,
    },
    math::{Rgb, Vec2, Vec3, WorkingSpace, trig},
    texture::{Color, Scalar, TextureId, TexturePoint, Textures},
    value::Channel,
};

/// The effect of opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    Opaque,
    /// Points with a lower opacity are not there.
    Mask(f32),
    Blend,
}

/// See the module. Parts are from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Principled {
    pub base_color: Color,
    pub metallic: Scalar,
    pub roughness: Scalar,
    pub ior: f32,
    /// 20 over the Abbe number; 0 is none.
    pub dispersion: f32,
    pub specular: Scalar,
    pub specular_color: Color,
    pub transmission: Scalar,
    pub diffuse_transmission: Scalar,
    pub diffuse_transmission_color: Color,
    pub boundary: Boundary,
    /// The absorption coefficient of the body, in m^-1.
    pub absorption: Rgb,
    /// See [`Medium::priority`].
    pub priority: i32,
    pub clearcoat: Scalar,
    pub clearcoat_roughness: Scalar,
    /// The normal map of the coat, which `normal` and `heights` do not turn.
    pub clearcoat_normal: Option<TangentNormals>,
    pub sheen_color: Color,
    pub sheen_roughness: Scalar,
    pub iridescence: Scalar,
    pub iridescence_ior: f32,
    /// The thickness of the film, in metres, where `iridescence_place` is 0 and where it is 1.
    pub iridescence_thickness: [f32; 2],
    pub iridescence_place: Scalar,
    /// The space of the colours of the film.
    pub space: WorkingSpace,
    pub anisotropy: Scalar,
    /// Red and green are a direction along tangent and bitangent, with texels as they are: 0.5 is 0.
    pub anisotropy_direction: Option<Color>,
    /// The rotation of that direction, else of the tangent, towards the bitangent, in radians.
    pub anisotropy_rotation: f32,
    /// In W m^-2 sr^-1, once it is multiplied by `emissive_strength`.
    pub emissive: Color,
    pub emissive_strength: f32,
    /// The normal map, with its texels as they are: 0.5 is 0.
    pub normal: Option<Color>,
    pub normal_scale: f32,
    /// Heights, where there is no normal map.
    pub heights: Option<HeightMap>,
    pub opacity: Scalar,
    pub alpha_mode: AlphaMode,
    /// Which of them shine.
    pub sidedness: Sidedness,
    /// Whether `base_color` and `opacity` are multiplied by those of the mesh's vertices.
    pub reads_vertices: bool,
    /// Whether what it emits is its colour, which lights nothing.
    pub is_unlit: bool,
}

impl Default for Principled {
    /// Light gray plastic.
    fn default() -> Self {
        let (none, all) = (Scalar::Constant(0.0), Scalar::Constant(1.0));
        let gray = |v| Color::Constant(Rgb::gray(v));
        Self {
            base_color: gray(0.8),
            metallic: none,
            roughness: Scalar::Constant(0.5),
            ior: 1.5,
            dispersion: 0.0,
            specular: all,
            specular_color: gray(1.0),
            transmission: none,
            diffuse_transmission: none,
            diffuse_transmission_color: gray(1.0),
            boundary: Boundary::ThinWalled,
            absorption: Rgb::BLACK,
            priority: 0,
            clearcoat: none,
            clearcoat_roughness: none,
            clearcoat_normal: None,
            sheen_color: gray(0.0),
            sheen_roughness: none,
            iridescence: none,
            iridescence_ior: 1.3,
            iridescence_thickness: [400e-9; 2],
            space: WorkingSpace::Rec709,
            iridescence_place: all,
            anisotropy: none,
            anisotropy_direction: None,
            anisotropy_rotation: 0.0,
            emissive: gray(0.0),
            emissive_strength: 1.0,
            normal: None,
            normal_scale: 1.0,
            heights: None,
            opacity: all,
            alpha_mode: AlphaMode::Blend,
            sidedness: Sidedness::Front,
            reads_vertices: false,
            is_unlit: false,
        }
    }
}

impl Principled {
    fn layers(&self, textures: &Textures<'_>, at: &TexturePoint) -> Layers {
        let unit_scalar = |scalar: &Scalar| textures.scalar(scalar, at).clamp(0.0, 1.0);
        let [thin, thick] = self.iridescence_thickness;
        let thin_film = ThinFilm {
            weight: unit_scalar(&self.iridescence),
            ior: self.iridescence_ior,
            thickness: thin + (thick - thin) * unit_scalar(&self.iridescence_place),
            space: self.space,
        };
        let transmission = unit_scalar(&self.transmission);
        let [roughness, metallic] = textures
            .pair([&self.roughness, &self.metallic], at)
            .map(|v| v.clamp(0.0, 1.0));
        let facets = Ggx::from_roughness(roughness, unit_scalar(&self.anisotropy));
        Layers {
            base_color: self.base_color(textures, at),
            metallic,
            boundary: self.boundary,
            transmission,
            diffuse_transmission: unit_scalar(&self.diffuse_transmission),
            diffuse_transmission_color: textures.color(&self.diffuse_transmission_color, at),
            facets: if self.boundary == Boundary::Solid && transmission > 0.0 {
                facets.isotropic()
            } else {
                facets
            },
            rotation: self.brushing(textures, at),
            ior: self.ior,
            dispersion: self.dispersion,
            hero: None,
            specular: unit_scalar(&self.specular),
            specular_color: textures.color(&self.specular_color, at),
            thin_film,
            coat: unit_scalar(&self.clearcoat),
            coat_facets: Ggx::from_roughness(unit_scalar(&self.clearcoat_roughness), 0.0),
            coat_normal: Vec3::Z,
            sheen: textures.color(&self.sheen_color, at),
            sheen_roughness: unit_scalar(&self.sheen_roughness),
        }
    }
}

impl Principled {
    /// The direction of the brushing along tangent and bitangent.
    fn brushing(&self, textures: &Textures<'_>, at: &TexturePoint) -> Vec2 {
        let (sin, cos) = match self.anisotropy_rotation {
            0.0 => (0.0, 1.0),
            angle => trig::sin_cos(angle),
        };
        let turn = Vec2::new(cos, sin);
        let Some(map) = &self.anisotropy_direction else {
            return turn;
        };
        let along = textures.data(map, at) * 2.0 - Rgb::WHITE;
        let along = Vec2::new(along.r, along.g).normalize_or(Vec2::X);
        textures.turned(map, turn.rotate(along), at)
    }
}

impl MaterialKind for Principled {
    fn whitted_terms(&self, textures: &Textures<'_>, at: &TexturePoint) -> WhittedTerms {
        let layers = self.layers(textures, at);
        let (metal, clear) = (layers.metallic, (1.0 - layers.metallic) * layers.transmission);
        let reflected = layers.reflectance_of_boundary();
        let coat = layers.coat * 0.04;
        let base = layers.base_color * (1.0 - metal - clear).max(0.0);
        let diffuse = base * ((1.0 - reflected.max_component()) * (1.0 - coat) * (1.0 - layers.diffuse_transmission));
        let mirror = layers.base_color * metal + reflected * (1.0 - metal - clear).max(0.0) + Rgb::gray(coat);
        let rough = layers.facets.alpha.max_element();
        let terms = WhittedTerms {
            // The surface reflects ambient light as well.
            ambient: base,
            diffuse: (diffuse + mirror * rough) * FRAC_1_PI,
            reflect: mirror * (1.0 - rough),
            ..WhittedTerms::default()
        };
        if clear == 0.0 {
            return terms;
        }
        match layers.refraction() {
            Boundary::ThinWalled => WhittedTerms {
                reflect: mirror * (1.0 - rough) + reflected * clear,
                transmit: layers.base_color * (clear * (1.0 - reflected.max_component())),
                ..terms
            },
            Boundary::Solid => WhittedTerms {
                reflect: Rgb::gray(clear),
                transmit: layers.base_color * clear,
                ior: self.ior,
                fresnel_mode: FresnelMode::Fresnel,
                ..terms
            },
        }
    }

    fn bsdf(&self, textures: &Textures<'_>, at: &TexturePoint) -> Bsdf {
        self.layers(textures, at).into()
    }

    fn batch_kind(&self) -> BatchKind {
        let is_none = |part| matches!(part, Scalar::Constant(0.0));
        let is_opaque = is_none(self.transmission) && is_none(self.diffuse_transmission);
        let has_one_normal = self.normal_map().is_none() && self.clearcoat_normal.is_none();
        if is_opaque && is_none(self.anisotropy) && (has_one_normal || is_none(self.clearcoat)) {
            BatchKind::Layered
        } else {
            BatchKind::Alone
        }
    }

    fn emission(&self) -> Option<Emission> {
        let dark = self.emissive_strength == 0.0 || matches!(self.emissive, Color::Constant(c) if c.is_black());
        (!dark).then_some(Emission {
            radiance: self.emissive,
            scale: self.emissive_strength,
            sidedness: self.sidedness,
            reach: if self.is_unlit {
                EmissionReach::Nothing
            } else {
                EmissionReach::Everything
            },
        })
    }

    fn opacity(&self, textures: &Textures<'_>, at: &TexturePoint) -> f32 {
        let opacity = || {
            let vertex = if self.reads_vertices { at.vertex.opacity } else { 1.0 };
            textures.scalar(&self.opacity, at) * vertex
        };
        match self.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask(cutoff) => f32::from(opacity() >= cutoff),
            AlphaMode::Blend => opacity().clamp(0.0, 1.0),
        }
    }

    fn opacity_texture(&self) -> Option<TextureId> {
        match self.opacity {
            Scalar::Texture(id, Channel::A, _) if self.alpha_mode != AlphaMode::Opaque => Some(id),
            _ => None,
        }
    }

    fn one_of_textures(&self) -> Option<TextureId> {
        let colors = [Some(&self.base_color), self.normal.as_ref()];
        let colors = colors.into_iter().flatten().filter_map(Color::texture);
        let scalars = [&self.roughness, &self.metallic]
            .into_iter()
            .filter_map(Scalar::texture);
        let mut all = colors.chain(scalars.map(|(id, _)| id));
        let first = all.next()?;
        all.any(|other| other != first).then_some(first)
    }

    fn is_invisible(&self, textures: &Textures<'_>) -> bool {
        let is_hidden = |opacity: f32| match self.alpha_mode {
            AlphaMode::Opaque => false,
            AlphaMode::Mask(cutoff) => opacity < cutoff,
            AlphaMode::Blend => opacity <= 0.0,
        };
        textures.all(&self.opacity, &is_hidden)
    }

    fn is_opaque(&self) -> bool {
        let everywhere = |v: f32| match self.alpha_mode {
            AlphaMode::Opaque => true,
            AlphaMode::Mask(cutoff) => v >= cutoff,
            AlphaMode::Blend => v >= 1.0,
        };
        let is_known = !self.reads_vertices;
        self.alpha_mode == AlphaMode::Opaque || is_known && matches!(self.opacity, Scalar::Constant(v) if everywhere(v))
    }

    #[inline]
    fn normal_map(&self) -> Option<NormalMap> {
        let normals = |color| {
            let scale = self.normal_scale;
            NormalMap::Normals(TangentNormals { color, scale })
        };
        self.normal.map(normals).or(self.heights.map(NormalMap::Heights))
    }

    fn coat_normal(&self, textures: &Textures<'_>, at: &TexturePoint) -> Option<Vec3> {
        match &self.clearcoat_normal {
            Some(map) => Some(map.normal(textures, at)),
            None => self.normal_map().map(|_| Vec3::Z),
        }
    }

    fn medium(&self) -> Option<Medium> {
        let is_none = |part| matches!(part, Scalar::Constant(0.0));
        let passes = !is_none(self.transmission) || !is_none(self.diffuse_transmission);
        (self.boundary == Boundary::Solid && passes).then_some(Medium {
            absorption: self.absorption,
            ior: self.ior,
            priority: self.priority,
        })
    }

    fn may_transmit_straight(&self) -> bool {
        let is_clear = !matches!(self.transmission, Scalar::Constant(0.0));
        let is_rough = matches!(self.roughness, Scalar::Constant(r) if !Ggx::from_roughness(r, 0.0).is_smooth());
        let is_straight = self.boundary == Boundary::ThinWalled || is_equal_ior(self.ior, 1.0);
        is_clear && !is_rough && is_straight
    }

    fn max_reflectance(&self, textures: &Textures<'_>) -> f32 {
        let reflected = textures.max_value(&self.base_color);
        match self.diffuse_transmission {
            Scalar::Constant(0.0) => reflected,
            _ => reflected.max(textures.max_value(&self.diffuse_transmission_color)),
        }
    }

    fn is_spatially_varying(&self) -> bool {
        let (colors, scalars) = self.sources();
        let is_constant = colors.into_iter().chain(self.maps()).all(Color::is_constant)
            && scalars.into_iter().all(Scalar::is_constant);
        let is_brushed = matches!(self.anisotropy, Scalar::Constant(a) if a > 0.0);
        // An unlit surface shows the colours of its vertices, which are white where it has none.
        !is_constant || is_brushed || self.reads_vertices || self.is_unlit || self.heights.is_some()
    }

    fn convert_colors(&mut self, space: WorkingSpace) {
        let (colors, _) = self.sources_mut();
        colors.into_iter().for_each(|color| color.convert(space));
        self.absorption = medium::converted_absorption(self.absorption, space);
        self.space = space;
    }
}
