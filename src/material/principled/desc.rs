//! The description of a principled material in a scene file.

use serde::Deserialize;

use super::{AlphaMode, Principled};
use crate::{
    bsdf::layered::Boundary,
    material::{Find, Sidedness, TangentNormals, medium, unit_scalar},
    math::{Rgb, trig},
    texture::Color,
    value::{
        Channel, ColorSource, Finite, NonNegative, Positive, Problem, RgbFactor, ScalarSource, Spanned, UnitInterval,
    },
};

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PrincipledDesc {
    pub base_color: Option<Spanned<ColorSource>>,
    pub metallic: Option<Spanned<ScalarSource>>,
    pub roughness: Option<Spanned<ScalarSource>>,
    pub ior: Option<Positive>,
    pub specular: Option<Spanned<ScalarSource>>,
    pub specular_color: Option<Spanned<ColorSource>>,
    pub transmission: Option<Spanned<ScalarSource>>,
    pub diffuse_transmission: Option<Spanned<ScalarSource>>,
    pub diffuse_transmission_color: Option<Spanned<ColorSource>>,
    pub thickness: Option<NonNegative>,
    pub dispersion: Option<NonNegative>,
    pub attenuation_color: Option<Spanned<RgbFactor>>,
    pub attenuation_distance: Option<Positive>,
    pub priority: i32,
    pub clearcoat: Option<Spanned<ScalarSource>>,
    pub clearcoat_roughness: Option<Spanned<ScalarSource>>,
    pub clearcoat_normal: Option<Spanned<ColorSource>>,
    pub clearcoat_normal_scale: Option<Finite>,
    pub sheen_color: Option<Spanned<ColorSource>>,
    pub sheen_roughness: Option<Spanned<ScalarSource>>,
    pub iridescence: Option<Spanned<ScalarSource>>,
    pub iridescence_ior: Option<Positive>,
    pub iridescence_thickness: Option<NonNegative>,
    pub anisotropy: Option<Spanned<ScalarSource>>,
    pub anisotropy_direction: Option<Spanned<ColorSource>>,
    pub anisotropy_rotation: Option<Finite>,
    pub emissive: Option<Spanned<ColorSource>>,
    pub emissive_strength: Option<NonNegative>,
    pub normal: Option<Spanned<ColorSource>>,
    pub normal_scale: Option<Finite>,
    pub opacity: Option<Spanned<ScalarSource>>,
    pub alpha: Option<AlphaModeDesc>,
    pub alpha_cutoff: Option<Spanned<UnitInterval>>,
    pub two_sided: bool,
}

/// The effect of opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AlphaModeDesc {
    Opaque,
    Mask,
    Blend,
}

impl PrincipledDesc {
    pub fn compile(&self, find: &Find<'_>) -> Result<Principled, Problem> {
        let plain = Principled::default();
        let color = |source: &Option<Spanned<ColorSource>>, default: Color| {
            source.as_ref().map_or(Ok(default), |source| find.color(source))
        };
        let unit_scalar = |source: &Option<Spanned<ScalarSource>>, default: f32, channel: Channel| {
            unit_scalar(source.as_ref(), default, channel, find)
        };
        if let (Some(color), None) = (&self.attenuation_color, self.attenuation_distance) {
            let message = "a colour needs the distance over which light takes it on";
            return Err(Problem::at(color.span(), message).with_help("add `attenuation_distance`, in metres"));
        }
        let attenuation = self.attenuation_color.as_ref().map_or(Rgb::WHITE, |c| c.get_ref().0);
        let has_body = self.thickness.is_some_and(|t| t.0 > 0.0) || self.attenuation_distance.is_some();
        Ok(Principled {
            base_color: color(&self.base_color, plain.base_color)?,
            metallic: unit_scalar(&self.metallic, 0.0, Channel::B)?,
            roughness: unit_scalar(&self.roughness, 0.5, Channel::G)?,
            ior: self.ior.map_or(plain.ior, f32::from),
            dispersion: self.dispersion.map_or(0.0, f32::from),
            specular: unit_scalar(&self.specular, 1.0, Channel::A)?,
            specular_color: color(&self.specular_color, plain.specular_color)?,
            transmission: unit_scalar(&self.transmission, 0.0, Channel::R)?,
            diffuse_transmission: unit_scalar(&self.diffuse_transmission, 0.0, Channel::A)?,
            diffuse_transmission_color: color(&self.diffuse_transmission_color, plain.diffuse_transmission_color)?,
            boundary: if has_body {
                Boundary::Solid
            } else {
                Boundary::ThinWalled
            },
            absorption: self
                .attenuation_distance
                .map_or(Rgb::BLACK, |distance| medium::absorption(attenuation, distance.0)),
            priority: self.priority,
            clearcoat: unit_scalar(&self.clearcoat, 0.0, Channel::R)?,
            clearcoat_roughness: unit_scalar(&self.clearcoat_roughness, 0.0, Channel::G)?,
            clearcoat_normal: match &self.clearcoat_normal {
                None => None,
                Some(source) => Some(TangentNormals {
                    color: find.directions(source)?,
                    scale: self.clearcoat_normal_scale.map_or(1.0, f32::from),
                }),
            },
            sheen_color: color(&self.sheen_color, plain.sheen_color)?,
            sheen_roughness: unit_scalar(&self.sheen_roughness, 0.0, Channel::A)?,
            iridescence: unit_scalar(&self.iridescence, 0.0, Channel::R)?,
            iridescence_ior: self.iridescence_ior.map_or(plain.iridescence_ior, f32::from),
            iridescence_thickness: self
                .iridescence_thickness
                .map_or(plain.iridescence_thickness, |nm| [nm.0 * 1e-9; 2]),
            anisotropy: unit_scalar(&self.anisotropy, 0.0, Channel::B)?,
            anisotropy_direction: self
                .anisotropy_direction
                .as_ref()
                .map(|source| find.directions(source))
                .transpose()?,
            anisotropy_rotation: self.anisotropy_rotation.map_or(0.0, |r| trig::radians(r.0)),
            emissive: color(&self.emissive, plain.emissive)?,
            emissive_strength: self.emissive_strength.map_or(1.0, f32::from),
            normal: self.normal.as_ref().map(|source| find.directions(source)).transpose()?,
            normal_scale: self.normal_scale.map_or(1.0, f32::from),
            opacity: unit_scalar(&self.opacity, 1.0, Channel::A)?,
            alpha_mode: self.alpha_mode()?,
            sidedness: if self.two_sided {
                Sidedness::Both
            } else {
                Sidedness::Front
            },
            ..plain
        })
    }

    fn alpha_mode(&self) -> Result<AlphaMode, Problem> {
        match (self.alpha.unwrap_or(AlphaModeDesc::Blend), &self.alpha_cutoff) {
            (AlphaModeDesc::Mask, cutoff) => Ok(AlphaMode::Mask(cutoff.as_ref().map_or(0.5, |c| c.get_ref().0))),
            (_, Some(cutoff)) => Err(Problem::at(cutoff.span(), "a cutoff goes with `alpha = \"mask\"`")),
            (AlphaModeDesc::Opaque, None) => Ok(AlphaMode::Opaque),
            (AlphaModeDesc::Blend, None) => Ok(AlphaMode::Blend),
        }
    }
}
