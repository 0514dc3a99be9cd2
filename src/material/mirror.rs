//! A perfect mirror on both sides.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `reflectance` | number or `[r, g, b]`: the fraction of light that is reflected | | 1 |
//!
//! ```toml
//! [material.silver]
//! mirror = { reflectance = [0.97, 0.96, 0.91] }
//! ```

use serde::Deserialize;

use super::{Find, MaterialKind, WhittedTerms};
use crate::{
    bsdf::{Bsdf, specular},
    math::{Rgb, WorkingSpace},
    texture::{TexturePoint, Textures},
    value::{Problem, RgbFactor},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MirrorDesc {
    #[serde(default = "RgbFactor::white")]
    pub reflectance: RgbFactor,
}

impl MirrorDesc {
    pub fn compile(&self, _find: &Find<'_>) -> Result<Mirror, Problem> {
        Ok(Mirror {
            reflectance: self.reflectance.0,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Mirror {
    pub reflectance: Rgb,
}

impl MaterialKind for Mirror {
    #[inline]
    fn whitted_terms(&self, _textures: &Textures<'_>, _at: &TexturePoint) -> WhittedTerms {
        WhittedTerms {
            reflect: self.reflectance,
            ..WhittedTerms::default()
        }
    }

    #[inline]
    fn has_lobes(&self) -> bool {
        false
    }

    fn is_lit(&self) -> bool {
        false
    }

    fn bsdf(&self, _textures: &Textures<'_>, _at: &TexturePoint) -> Bsdf {
        Bsdf::Mirror(specular::Mirror {
            reflectance: self.reflectance,
        })
    }

    fn max_reflectance(&self, _textures: &Textures<'_>) -> f32 {
        self.reflectance.max_component()
    }

    fn is_spatially_varying(&self) -> bool {
        false
    }

    fn convert_colors(&mut self, space: WorkingSpace) {
        self.reflectance = space.from_rec709(self.reflectance);
    }
}
