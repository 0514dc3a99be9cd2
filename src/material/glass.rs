//! Clear glass, smooth or frosted, which reflects and refracts by Fresnel's equations.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `ior` | index of refraction of the inside, to which the normal does not point; above 0 | | 1.5 |
//! | `reflectance` | number or `[r, g, b]`: tint of the mirror image | | 1 |
//! | `transmittance` | number or `[r, g, b]`: tint of what is seen through the surface | | 1 |
//! | `roughness` | number from 0 to 1 or `"texture.NAME"` (channel g); its square is the alpha of the distribution | | 0 |
//! | `distribution` | `"ggx"` or `"beckmann"`: how steep microfacets are, see `metal` | | `"ggx"` |
//! | `absorption` | number or `[r, g, b]`: absorption coefficient of the inside | m^-1 | 0 |
//! | `attenuation_color` | `[r, g, b]`, instead of `absorption`: the colour of white light after `attenuation_distance` | | 1 |
//! | `attenuation_distance` | number above 0 | m | no absorption |
//! | `priority` | whole number: where bodies overlap, the one of the highest priority fills the place, and of equals the one that light entered last | | 0 |
//! | `thin_walled` | whether the surface is a thin pane: light goes straight through, and there is no inside | | false |
//!
//! ```toml
//! [material.window]
//! glass = { ior = 1.5, transmittance = [0.9, 1, 0.95], thin_walled = true }
//!
//! [material.bottle]
//! glass = { roughness = 0.3, attenuation_color = [0.2, 0.6, 0.3], attenuation_distance = 0.02 }
//! ```
//!
//! Bodies may lie in each other or overlap: a bubble of air is a body of `ior = 1` in a liquid, and a liquid in a glass reaches a
//! little into its wall, which has the higher `priority`. Each index of refraction is the body's own; what counts at a surface is
//! its ratio to what is around. A camera may be inside.
//!
//! Shadow rays do not refract, so glass blocks them: light behind it (caustics) is found only by paths that hit a light. What
//! lets light straight through lets them pass: a smooth thin wall, and a body with the index of refraction of its surroundings.
//! In the absorbing inside of a body they are absorbed.
//!
//! Light that bounces several times between microfacets is included, with albedos for each distribution.
//!
//! Radiance is not scaled by the square of the index of refraction: what is seen through the surface is as bright as what
//! is behind it. The `whitted` integrator ignores roughness and absorption.
//!
//! # Implementation
//!
//! Sources: see [`crate::bsdf::fresnel`], [`crate::bsdf::microfacet`] and, for light that bounces between microfacets,
//! [`crate::bsdf::albedo`].

use serde::Deserialize;

use super::{Find, FresnelMode, MaterialKind, Medium, WhittedTerms, medium, unit_scalar};
use crate::{
    bsdf::{
        Bsdf,
        albedo::MirrorFacets,
        beckmann::Beckmann,
        dielectric::{BoundaryFacets, RoughDielectric, ThinDielectric, double_boundary},
        fresnel::dielectric,
        is_equal_ior,
        layered::Boundary,
        microfacet::{Distribution, Facets, Ggx},
    },
    math::{Rgb, WorkingSpace},
    texture::{Scalar, TexturePoint, Textures},
    value::{Channel, Positive, Problem, RgbFactor, ScalarSource, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GlassDesc {
    #[serde(default = "ior")]
    pub ior: Positive,
    #[serde(default = "RgbFactor::white")]
    pub reflectance: RgbFactor,
    #[serde(default = "RgbFactor::white")]
    pub transmittance: RgbFactor,
    pub roughness: Option<Spanned<ScalarSource>>,
    pub absorption: Option<Spanned<RgbFactor>>,
    pub attenuation_color: Option<Spanned<RgbFactor>>,
    pub attenuation_distance: Option<Spanned<Positive>>,
    #[serde(default)]
    pub priority: i32,
    #[serde(default)]
    pub thin_walled: bool,
    #[serde(default)]
    pub distribution: Distribution,
}

fn ior() -> Positive {
    Positive(1.5)
}

impl GlassDesc {
    pub fn compile(&self, find: &Find<'_>) -> Result<Glass, Problem> {
        Ok(Glass {
            ior: self.ior.0,
            reflectance: self.reflectance.0,
            transmittance: self.transmittance.0,
            roughness: unit_scalar(self.roughness.as_ref(), 0.0, Channel::G, find)?,
            absorption: self.absorption()?,
            priority: self.priority,
            boundary: if self.thin_walled {
                Boundary::ThinWalled
            } else {
                Boundary::Solid
            },
            distribution: self.distribution,
        })
    }

    /// The absorption coefficient of the inside, in m^-1.
    fn absorption(&self) -> Result<Rgb, Problem> {
        let distance = self.attenuation_distance.as_ref();
        let given = [
            self.absorption.as_ref().map(Spanned::span),
            self.attenuation_color.as_ref().map(Spanned::span),
            distance.map(Spanned::span),
        ];
        if let (true, Some(span)) = (self.thin_walled, given.iter().flatten().next()) {
            return Err(Problem::at(span.clone(), "a thin wall has no inside that absorbs")
                .with_help("leave it out, and tint `transmittance`"));
        }
        match (&self.absorption, &self.attenuation_color, distance) {
            (Some(_), _, Some(twice)) => Err(given_twice(twice.span())),
            (Some(_), Some(twice), None) => Err(given_twice(twice.span())),
            (Some(absorption), None, None) => Ok(absorption.get_ref().0),
            (None, Some(color), None) => {
                let message = "a colour needs the distance over which light takes it on";
                Err(Problem::at(color.span(), message).with_help("add `attenuation_distance`, in metres"))
            }
            (None, color, Some(distance)) => {
                let color = color.as_ref().map_or(Rgb::WHITE, |c| c.get_ref().0);
                Ok(medium::absorption(color, distance.get_ref().0))
            }
            (None, None, None) => Ok(Rgb::BLACK),
        }
    }
}

fn given_twice(span: std::ops::Range<usize>) -> Problem {
    Problem::at(span, "the absorption is given twice")
        .with_help("give `absorption`, or `attenuation_color` and its distance")
}

#[derive(Clone, Copy, Debug)]
pub struct Glass {
    pub ior: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
    /// Perceived, from 0 to 1.
    pub roughness: Scalar,
    /// The absorption coefficient of the inside, in m^-1.
    pub absorption: Rgb,
    /// See [`Medium::priority`].
    pub priority: i32,
    pub boundary: Boundary,
    pub distribution: Distribution,
}

impl Glass {
    /// Its solid boundary, with this distribution of facets.
    fn solid<F: BoundaryFacets>(&self, roughness: f32) -> Bsdf {
        RoughDielectric {
            facets: F::from_roughness(roughness, 0.0),
            ior: self.ior,
            reflectance: self.reflectance,
            transmittance: self.transmittance,
        }
        .into()
    }

    /// A pane, with this distribution of facets.
    fn pane<F: MirrorFacets>(&self, roughness: f32) -> ThinDielectric<F> {
        ThinDielectric {
            facets: F::from_roughness(roughness, 0.0),
            ior: self.ior,
            reflectance: self.reflectance,
            transmittance: self.transmittance,
        }
    }
}

impl MaterialKind for Glass {
    #[inline]
    fn whitted_terms(&self, _textures: &Textures<'_>, _at: &TexturePoint) -> WhittedTerms {
        match self.boundary {
            Boundary::Solid => WhittedTerms {
                reflect: self.reflectance,
                transmit: self.transmittance,
                ior: self.ior,
                fresnel_mode: FresnelMode::Fresnel,
                ..WhittedTerms::default()
            },
            Boundary::ThinWalled => {
                let reflected = double_boundary(dielectric(1.0, self.ior));
                WhittedTerms {
                    reflect: self.reflectance * reflected,
                    transmit: self.transmittance * (1.0 - reflected),
                    ..WhittedTerms::default()
                }
            }
        }
    }

    fn is_lit(&self) -> bool {
        false
    }

    #[inline]
    fn bsdf(&self, textures: &Textures<'_>, at: &TexturePoint) -> Bsdf {
        let roughness = textures.scalar(&self.roughness, at).clamp(0.0, 1.0);
        match (self.boundary, self.distribution) {
            (Boundary::Solid, Distribution::Ggx) => self.solid::<Ggx>(roughness),
            (Boundary::Solid, Distribution::Beckmann) => self.solid::<Beckmann>(roughness),
            (Boundary::ThinWalled, Distribution::Ggx) => Bsdf::ThinDielectric(self.pane(roughness)),
            (Boundary::ThinWalled, Distribution::Beckmann) => Bsdf::BeckmannPane(self.pane(roughness)),
        }
    }

    fn medium(&self) -> Option<Medium> {
        (self.boundary == Boundary::Solid).then_some(Medium {
            absorption: self.absorption,
            ior: self.ior,
            priority: self.priority,
        })
    }

    fn may_transmit_straight(&self) -> bool {
        match self.boundary {
            Boundary::Solid => is_equal_ior(self.ior, 1.0),
            Boundary::ThinWalled => {
                !matches!(self.roughness, Scalar::Constant(r) if !Ggx::from_roughness(r, 0.0).is_smooth())
            }
        }
    }

    fn max_reflectance(&self, _textures: &Textures<'_>) -> f32 {
        self.reflectance.max_component().max(self.transmittance.max_component())
    }

    fn is_spatially_varying(&self) -> bool {
        !self.roughness.is_constant()
    }

    fn convert_colors(&mut self, space: WorkingSpace) {
        self.reflectance = space.from_rec709(self.reflectance);
        self.transmittance = space.from_rec709(self.transmittance);
        self.absorption = medium::converted_absorption(self.absorption, space);
    }
}
