//! A diffuse surface such as paper or unglazed clay: Lambert's model, or Oren and Nayar's where it is rough.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `albedo` | number, `[r, g, b]` or `"texture.NAME"`: the fraction of light that is reflected | | required |
//! | `roughness` | number from 0 to 1 or `"texture.NAME"` (channel r): 0 is Lambert's model, 1 looks as flat as the full moon | | 0 |
//!
//! ```toml
//! [material.wall]
//! matte = { albedo = [0.7, 0.7, 0.7] }
//!
//! [material.clay]
//! matte = { albedo = [0.6, 0.4, 0.3], roughness = 0.8 }
//! ```
//!
//! Both sides reflect. Irradiance E leaves as the radiance E albedo max(n.l, 0) / pi. A roughness r is about Oren and
//! Nayar's standard deviation of slopes in units of pi / 2. The `whitted` integrator ignores the roughness.
//!
//! # Implementation
//!
//! Source: [`crate::bsdf::diffuse::OrenNayar`].

use std::f32::consts::FRAC_1_PI;

use serde::Deserialize;

use super::{BatchKind, Find, Material, MaterialKind, WhittedTerms, unit_scalar};
use crate::{
    bsdf::{
        Bsdf,
        diffuse::{Lambert, OrenNayar},
    },
    math::{Rgb, WorkingSpace},
    texture::{Color, Scalar, TexturePoint, Textures},
    value::{Channel, ColorSource, Problem, ScalarSource, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MatteDesc {
    pub albedo: Spanned<ColorSource>,
    pub roughness: Option<Spanned<ScalarSource>>,
}

impl MatteDesc {
    pub fn compile(&self, find: &Find<'_>) -> Result<Matte, Problem> {
        Ok(Matte {
            albedo: find.color(&self.albedo)?,
            roughness: unit_scalar(self.roughness.as_ref(), 0.0, Channel::R, find)?,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Matte {
    pub albedo: Color,
    /// From 0 to 1.
    pub roughness: Scalar,
}

impl Matte {
    /// Lambert's.
    pub fn smooth(albedo: Color) -> Self {
        Self {
            albedo,
            roughness: Scalar::Constant(0.0),
        }
    }
}

impl Material {
    /// It reflects nothing.
    pub fn black() -> Self {
        Self::Matte(Matte::smooth(Color::Constant(Rgb::BLACK)))
    }
}

impl MaterialKind for Matte {
    #[inline]
    fn whitted_terms(&self, textures: &Textures<'_>, at: &TexturePoint) -> WhittedTerms {
        let albedo = textures.color(&self.albedo, at);
        WhittedTerms {
            ambient: albedo,
            diffuse: albedo * FRAC_1_PI,
            ..WhittedTerms::default()
        }
    }

    #[inline]
    fn has_lobes(&self) -> bool {
        false
    }

    fn bsdf(&self, textures: &Textures<'_>, at: &TexturePoint) -> Bsdf {
        let albedo = textures.color(&self.albedo, at);
        let roughness = textures.scalar(&self.roughness, at);
        if roughness > 0.0 {
            let roughness = roughness.min(1.0);
            Bsdf::OrenNayar(OrenNayar { albedo, roughness })
        } else {
            Bsdf::Lambert(Lambert { albedo })
        }
    }

    fn batch_kind(&self) -> BatchKind {
        match self.roughness {
            Scalar::Constant(roughness) if roughness <= 0.0 => BatchKind::Diffuse,
            _ => BatchKind::RoughDiffuse,
        }
    }

    fn max_reflectance(&self, textures: &Textures<'_>) -> f32 {
        textures.max_value(&self.albedo)
    }

    fn is_spatially_varying(&self) -> bool {
        !(self.albedo.is_constant() && self.roughness.is_constant())
    }

    fn convert_colors(&mut self, space: WorkingSpace) {
        self.albedo.convert(space);
    }
}
