//! Chalk: light leaves in all directions alike (Lambert).
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `albedo` | `[r, g, b]` or `"texture.NAME"`; the part of the light that is reflected | | required |
//!
//! Seen from both sides. A light of irradiance E leaves as E albedo max(n.l, 0) / pi.
//!
//! ```toml
//! [material.wall]
//! matte = { albedo = [0.7, 0.7, 0.7] }
//! ```

use std::f32::consts::FRAC_1_PI;

use serde::Deserialize;

use super::{FindColor, MaterialKind, Terms};
use crate::{
    bsdf::{Bsdf, diffuse::Lambert},
    texture::{Color, TexturePoint, Textures},
    value::{ColorSource, Problem, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MatteDesc {
    pub albedo: Spanned<ColorSource>,
}

impl MatteDesc {
    pub fn compile(&self, find: &FindColor<'_>) -> Result<Matte, Problem> {
        Ok(Matte {
            albedo: find(&self.albedo)?,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Matte {
    pub albedo: Color,
}

impl MaterialKind for Matte {
    #[inline]
    fn terms(&self, textures: &Textures<'_>, at: &TexturePoint) -> Terms {
        let albedo = textures.color(&self.albedo, at);
        Terms {
            ambient: albedo,
            diffuse: albedo * FRAC_1_PI,
            ..Terms::default()
        }
    }

    #[inline]
    fn bsdf(&self, textures: &Textures<'_>, at: &TexturePoint) -> Bsdf {
        Bsdf::Lambert(Lambert {
            albedo: textures.color(&self.albedo, at),
        })
    }
}
