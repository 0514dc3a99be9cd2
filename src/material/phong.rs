//! The classic Phong model: ambient, diffuse and specular terms, mirror reflection and transparency.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `color` | `[r, g, b]` or `"texture.NAME"`: ambient and diffuse colour | | required |
//! | `specular` | number or `[r, g, b]`: strength of the highlight | | 0 |
//! | `shininess` | exponent of the highlight, at least 0 | | 32 |
//! | `reflect` | number or `[r, g, b]`: weight of the mirror image | | 0 |
//! | `transmit` | number or `[r, g, b]`: weight of what is seen through the surface | | 0 |
//! | `ior` | index of refraction of the inside, to which the normal does not point; above 0 | | 1.5 |
//! | `two_sided` | whether the normal is flipped towards the viewer | | false |
//!
//! ```toml
//! [material.ball]
//! phong = { color = [0, 0, 1], specular = 1, shininess = 4, reflect = 0.8 }
//! ```
//!
//! With the `whitted` integrator a light of irradiance E adds E (color max(n.l, 0) + specular max(r.v, 0)^shininess). There
//! is no factor 1/pi, so the numbers are display values rather than reflectances. With `two_sided = false` the normal is
//! used as authored: a face that points away from the viewer shows its ambient term only. At total internal reflection the
//! weight of `transmit` goes to the mirror image.
//!
//! In all other integrators `color` and `specular` are fractions of light, reflected diffusely and about the mirror
//! direction. Where the weights add up to more than 1, they are scaled down to 1. Both sides reflect there.
//!
//! # Implementation
//!
//! The BSDF is [`crate::bsdf::phong`].

use serde::Deserialize;

use super::{Find, FresnelMode, MaterialKind, WhittedTerms};
use crate::{
    bsdf::{self, Bsdf, diffuse::Lambert, phong::PhongWeights},
    math::{Rgb, WorkingSpace},
    texture::{Color, TexturePoint, Textures},
    value::{ColorSource, NonNegative, Positive, Problem, RgbFactor, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PhongDesc {
    pub color: Spanned<ColorSource>,
    #[serde(default = "black")]
    pub specular: RgbFactor,
    #[serde(default = "shininess")]
    pub shininess: NonNegative,
    #[serde(default = "black")]
    pub reflect: RgbFactor,
    #[serde(default = "black")]
    pub transmit: RgbFactor,
    #[serde(default = "ior")]
    pub ior: Positive,
    #[serde(default)]
    pub two_sided: bool,
}

fn ior() -> Positive {
    Positive(1.5)
}

fn black() -> RgbFactor {
    RgbFactor(Rgb::BLACK)
}

fn shininess() -> NonNegative {
    NonNegative(32.0)
}

impl PhongDesc {
    pub fn compile(&self, find: &Find<'_>) -> Result<Phong, Problem> {
        Ok(Phong {
            color: find.color(&self.color)?,
            specular: self.specular.0,
            shininess: self.shininess.0,
            reflect: self.reflect.0,
            transmit: self.transmit.0,
            ior: self.ior.0,
            two_sided: self.two_sided,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Phong {
    pub color: Color,
    pub specular: Rgb,
    pub shininess: f32,
    pub reflect: Rgb,
    pub transmit: Rgb,
    pub ior: f32,
    pub two_sided: bool,
}

impl Default for Phong {
    /// White and dull.
    fn default() -> Self {
        Self {
            color: Color::Constant(Rgb::WHITE),
            specular: Rgb::BLACK,
            shininess: shininess().0,
            reflect: Rgb::BLACK,
            transmit: Rgb::BLACK,
            ior: ior().0,
            two_sided: false,
        }
    }
}

impl Phong {
    /// Whether only the colour is set.
    fn is_dull(&self) -> bool {
        (self.specular + self.reflect + self.transmit).is_black()
    }
}

impl MaterialKind for Phong {
    #[inline]
    fn whitted_terms(&self, textures: &Textures<'_>, at: &TexturePoint) -> WhittedTerms {
        let color = textures.color(&self.color, at);
        WhittedTerms {
            ambient: color,
            diffuse: color,
            specular: self.specular,
            shininess: self.shininess,
            reflect: self.reflect,
            transmit: self.transmit,
            ior: self.ior,
            fresnel_mode: FresnelMode::Fixed,
            two_sided: self.two_sided,
        }
    }

    #[inline]
    fn bsdf(&self, textures: &Textures<'_>, at: &TexturePoint) -> Bsdf {
        let diffuse = textures.color(&self.color, at);
        if self.is_dull() {
            let albedo = diffuse.map(|c| c.min(1.0));
            return Bsdf::Lambert(Lambert { albedo });
        }
        let weights = PhongWeights {
            diffuse,
            specular: self.specular,
            reflect: self.reflect,
            transmit: self.transmit,
        };
        Bsdf::Phong(bsdf::phong::Phong::new(weights, self.shininess, self.ior))
    }

    fn max_reflectance(&self, textures: &Textures<'_>) -> f32 {
        let weights = [self.specular, self.reflect, self.transmit].map(Rgb::max_component);
        weights.into_iter().fold(textures.max_value(&self.color), f32::max)
    }

    fn is_spatially_varying(&self) -> bool {
        !self.color.is_constant()
    }

    fn convert_colors(&mut self, space: WorkingSpace) {
        self.color.convert(space);
        for color in [&mut self.specular, &mut self.reflect, &mut self.transmit] {
            *color = space.from_rec709(*color);
        }
    }
}
