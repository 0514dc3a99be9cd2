//! A mixture of two materials, such as paint that is worn down to the metal.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `a`, `b` | names of materials: both opaque, without light of their own | | required |
//! | `factor` | number from 0 to 1 or `"texture.NAME"` (channel r): the share of `b` | | 0.5 |
//!
//! ```toml
//! [material.worn]
//! mix = { a = "paint", b = "steel", factor = "texture.scratches" }
//!
//! [material.paint]
//! principled = { base_color = [0.6, 0.05, 0.03], roughness = 0.4, clearcoat = 1 }
//!
//! [material.steel]
//! metal = { preset = "iron", roughness = 0.35 }
//!
//! [texture.scratches]
//! stripes = { a = 0, b = 1, width = 0.05 }
//! ```
//!
//! The light that the surface reflects is the sum of both, weighted by their shares: each vertex of a path has one of the two,
//! chosen at random by the factor. So where the factor is neither 0 nor 1, a picture needs more samples than with one material,
//! with the `whitted` integrator as well. A component may be a mixture. Cryptomatte and `materialId` name the mixture.
//!
//! Glass, emitters and materials with an opacity cannot be mixed.

use serde::Deserialize;

use super::{Find, MaterialKind, Mixture, WhittedTerms, unit_scalar};
use crate::{
    bsdf::{Bsdf, diffuse::Lambert},
    math::{Rgb, WorkingSpace},
    texture::{TexturePoint, Textures},
    value::{Channel, Problem, ScalarSource, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MixDesc {
    pub a: Spanned<String>,
    pub b: Spanned<String>,
    pub factor: Option<Spanned<ScalarSource>>,
}

impl MixDesc {
    pub fn compile(&self, find: &Find<'_>) -> Result<Mix, Problem> {
        Ok(Mix(Mixture {
            materials: [find.material(&self.a)?, find.material(&self.b)?],
            factor: unit_scalar(self.factor.as_ref(), 0.5, Channel::R, find)?,
        }))
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Mix(Mixture);

impl MaterialKind for Mix {
    fn mixture(&self) -> Option<&Mixture> {
        Some(&self.0)
    }

    /// Black: one of the materials is shaded in its place.
    fn whitted_terms(&self, _textures: &Textures<'_>, _at: &TexturePoint) -> WhittedTerms {
        WhittedTerms::default()
    }

    /// Black: one of the materials is shaded in its place.
    fn bsdf(&self, _textures: &Textures<'_>, _at: &TexturePoint) -> Bsdf {
        Bsdf::Lambert(Lambert { albedo: Rgb::BLACK })
    }

    fn convert_colors(&mut self, _space: WorkingSpace) {}
}
