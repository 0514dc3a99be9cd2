//! A surface that emits light and reflects none: its objects are area lights.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `radiance` | number, `[r, g, b]` or `"texture.NAME"` of at least 0, the same in all directions | W m^-2 sr^-1 | required |
//! | `scale` | factor of at least 0, for textures | | 1 |
//! | `two_sided` | whether the back, to which the normal does not point, emits as well | | false |
//!
//! ```toml
//! [material.lamp]
//! emitter = { radiance = [12, 11, 9] }
//! ```
//!
//! A flat emitter of area A has a power of pi A radiance watts on each side that emits.

use serde::Deserialize;

use super::{Emission, EmissionReach, Find, MaterialKind, Sidedness, WhittedTerms};
use crate::{
    bsdf::{Bsdf, diffuse::Lambert},
    math::{Rgb, WorkingSpace},
    texture::{Color, TexturePoint, Textures},
    value::{ColorSource, NonNegative, Problem, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EmitterDesc {
    pub radiance: Spanned<ColorSource>,
    #[serde(default = "NonNegative::one")]
    pub scale: NonNegative,
    #[serde(default)]
    pub two_sided: bool,
}

impl EmitterDesc {
    pub fn compile(&self, find: &Find<'_>) -> Result<Emitter, Problem> {
        Ok(Emitter {
            radiance: find.color(&self.radiance)?,
            scale: self.scale.0,
            sidedness: if self.two_sided {
                Sidedness::Both
            } else {
                Sidedness::Front
            },
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Emitter {
    pub radiance: Color,
    pub scale: f32,
    pub sidedness: Sidedness,
}

impl MaterialKind for Emitter {
    fn whitted_terms(&self, _textures: &Textures<'_>, _at: &TexturePoint) -> WhittedTerms {
        WhittedTerms::default()
    }

    fn has_lobes(&self) -> bool {
        false
    }

    fn bsdf(&self, _textures: &Textures<'_>, _at: &TexturePoint) -> Bsdf {
        Bsdf::Lambert(Lambert { albedo: Rgb::BLACK })
    }

    fn emission(&self) -> Option<Emission> {
        Some(Emission {
            radiance: self.radiance,
            scale: self.scale,
            sidedness: self.sidedness,
            reach: EmissionReach::Everything,
        })
    }

    fn is_spatially_varying(&self) -> bool {
        !self.radiance.is_constant()
    }

    fn convert_colors(&mut self, space: WorkingSpace) {
        self.radiance.convert(space);
    }
}
