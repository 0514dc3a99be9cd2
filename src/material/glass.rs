//! Clear glass with a smooth surface: it reflects and refracts, shared out by Fresnel's equations.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `ior` | number above 0; index of refraction of the inside, where the normal does not point | | 1.5 |
//! | `reflectance` | number or `[r, g, b]`; weight of the mirror image | | 1 |
//! | `transmittance` | number or `[r, g, b]`; weight of what is seen through the surface | | 1 |
//!
//! Its shadow is black: a shadow ray does not bend.
//!
//! ```toml
//! [material.window]
//! glass = { ior = 1.5, transmittance = [0.9, 1, 0.95] }
//! ```
//!
//! Source: see [`crate::bsdf::fresnel`].

use serde::Deserialize;

use super::{FindColor, MaterialKind, Split, Terms};
use crate::{
    bsdf::{Bsdf, specular},
    math::Rgb,
    texture::{TexturePoint, Textures},
    value::{Positive, Problem, Tint},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GlassDesc {
    #[serde(default = "ior")]
    pub ior: Positive,
    #[serde(default = "white")]
    pub reflectance: Tint,
    #[serde(default = "white")]
    pub transmittance: Tint,
}

fn ior() -> Positive {
    Positive(1.5)
}

fn white() -> Tint {
    Tint(Rgb::WHITE)
}

impl GlassDesc {
    pub fn compile(&self, _find: &FindColor<'_>) -> Result<Glass, Problem> {
        Ok(Glass {
            ior: self.ior.0,
            reflectance: self.reflectance.0,
            transmittance: self.transmittance.0,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Glass {
    pub ior: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

impl MaterialKind for Glass {
    #[inline]
    fn terms(&self, _textures: &Textures<'_>, _at: &TexturePoint) -> Terms {
        Terms {
            reflect: self.reflectance,
            transmit: self.transmittance,
            ior: self.ior,
            split: Split::Fresnel,
            ..Terms::default()
        }
    }

    #[inline]
    fn bsdf(&self, _textures: &Textures<'_>, _at: &TexturePoint) -> Bsdf {
        Bsdf::Glass(specular::Glass {
            ior: self.ior,
            reflectance: self.reflectance,
            transmittance: self.transmittance,
        })
    }
}
