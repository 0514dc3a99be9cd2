//! Metal: polished, rough or brushed.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `preset` | `"aluminium"`, `"chromium"`, `"copper"`, `"gold"`, `"iron"`, `"nickel"`, `"platinum"`, `"silver"` or `"titanium"` | | |
//! | `eta`, `k` | number or `[r, g, b]`: real and imaginary part of the index of refraction | | |
//! | `tint` | number, `[r, g, b]` or `"texture.NAME"`, with `preset` or `eta` and `k`: multiplies their reflectance | | 1 |
//! | `color` | number, `[r, g, b]` or `"texture.NAME"`: reflectance at normal incidence | | |
//! | `edge` | number or `[r, g, b]` of at most 1, with `color`: tint of the reflectance at 82 degrees | | 1 |
//! | `roughness` | number from 0 to 1 or `"texture.NAME"` (channel g); its square is the alpha of the distribution | | 0 |
//! | `anisotropy` | number from 0 to 1: stretches highlights along the tangent, as on metal that is brushed across it | | 0 |
//! | `distribution` | `"ggx"` or `"beckmann"`: how steep microfacets are. Highlights of the second have no tails | | `"ggx"` |
//!
//! One of `preset`, `eta` with `k`, or `color` is required.
//!
//! ```toml
//! [material.ring]
//! metal = { preset = "gold", roughness = 0.15 }
//!
//! [material.pan]
//! metal = { color = [0.9, 0.9, 0.92], roughness = 0.4, anisotropy = 0.7 }
//!
//! [material.coin]
//! metal = { preset = "copper", roughness = 0.4, distribution = "beckmann" }
//! ```
//!
//! Both sides reflect. Light that bounces several times between microfacets is included: a white metal loses less than 2 %
//! of the light at any roughness and anisotropy, and gains none. Each distribution has albedos of its own for that. Programs
//! without multiple scattering, such as Mitsuba, look the same where surfaces are smooth, and darker up to half where they are
//! rough. Along the tangent the alpha is alpha + (1 - alpha) anisotropy^2, as in glTF's KHR_materials_anisotropy. The `whitted`
//! integrator shows a mirror with the reflectance at normal incidence.
//!
//! The presets are measurements at 616.8, 548.6 and 450.9 nm. Sources: Johnson and Christy, "Optical constants of the noble
//! metals", Phys. Rev. B 6, 1972, doi:10.1103/PhysRevB.6.4370 (silver, gold, copper), and "Optical constants of transition
//! metals", Phys. Rev. B 9, 1974, doi:10.1103/PhysRevB.9.5056 (chromium, iron, nickel, titanium); Rakic, Appl. Opt. 34,
//! 1995, doi:10.1364/AO.34.004755 (aluminium, interpolated); Rakic et al., Appl. Opt. 37, 1998, doi:10.1364/AO.37.005271
//! (platinum, their model).

use serde::Deserialize;

use super::{BatchKind, Find, MaterialKind, WhittedTerms, unit_scalar};
use crate::{
    bsdf::{
        Bsdf,
        beckmann::Beckmann,
        conductor::{Conductor, Reflectance},
        microfacet::{Distribution, Facets, Ggx},
    },
    math::{Rgb, WorkingSpace},
    texture::{Color, Scalar, TexturePoint, Textures},
    value::{Channel, ColorSource, Problem, RgbFactor, ScalarSource, Spanned, UnitInterval},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MetalDesc {
    pub preset: Option<Spanned<Preset>>,
    pub eta: Option<Spanned<RgbFactor>>,
    pub k: Option<Spanned<RgbFactor>>,
    pub tint: Option<Spanned<ColorSource>>,
    pub color: Option<Spanned<ColorSource>>,
    pub edge: Option<Spanned<RgbFactor>>,
    pub roughness: Option<Spanned<ScalarSource>>,
    pub anisotropy: Option<UnitInterval>,
    #[serde(default)]
    pub distribution: Distribution,
}

/// Metals that were measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    Aluminium,
    Chromium,
    Copper,
    Gold,
    Iron,
    Nickel,
    Platinum,
    Silver,
    Titanium,
}

impl Preset {
    /// Real and imaginary part of the index of refraction for red, green and blue.
    #[allow(clippy::approx_constant, reason = "chromium's k is 3.14 as measured")]
    fn index(self) -> [[f32; 3]; 2] {
        match self {
            Self::Aluminium => [[1.350, 1.009, 0.636], [7.371, 6.611, 5.465]],
            Self::Chromium => [[3.17, 3.18, 2.33], [3.30, 3.33, 3.14]],
            Self::Copper => [[0.30, 1.02, 1.24], [3.205, 2.577, 2.397]],
            Self::Gold => [[0.21, 0.43, 1.38], [3.272, 2.455, 1.914]],
            Self::Iron => [[2.88, 2.95, 2.59], [3.05, 2.93, 2.77]],
            Self::Nickel => [[1.99, 1.92, 1.73], [4.02, 3.61, 2.95]],
            Self::Platinum => [[2.276, 2.087, 1.854], [4.088, 3.696, 3.146]],
            Self::Silver => [[0.06, 0.06, 0.04], [4.152, 3.586, 2.657]],
            Self::Titanium => [[2.67, 2.54, 2.27], [3.72, 3.43, 3.04]],
        }
    }
}

impl MetalDesc {
    pub fn compile(&self, find: &Find<'_>) -> Result<Metal, Problem> {
        Ok(Metal {
            color: self.color(find)?,
            roughness: unit_scalar(self.roughness.as_ref(), 0.0, Channel::G, find)?,
            anisotropy: self.anisotropy.map_or(0.0, f32::from),
            distribution: self.distribution,
        })
    }

    fn color(&self, find: &Find<'_>) -> Result<MetalColor, Problem> {
        const HELP: &str = "give one of `preset`, `eta` with `k`, and `color`";
        if let (None, Some(edge)) = (&self.color, &self.edge) {
            return Err(Problem::at(edge.span(), "an `edge` goes with a `color`"));
        }
        if let (Some(_), Some(tint)) = (&self.color, &self.tint) {
            return Err(Problem::at(
                tint.span(),
                "a `tint` goes with `preset`, or with `eta` and `k`",
            ));
        }
        let measured = |eta, k| {
            let tint = self.tint.as_ref().map(|tint| find.color(tint)).transpose()?;
            Ok(MetalColor::Measured {
                reflectance: Reflectance::Measured { eta, k },
                tint: tint.unwrap_or(Color::Constant(Rgb::WHITE)),
            })
        };
        match (&self.preset, (&self.eta, &self.k), &self.color) {
            (Some(preset), (None, None), None) => {
                let [eta, k] = preset.get_ref().index().map(Rgb::from_array);
                measured(eta, k)
            }
            (None, (Some(eta), Some(k)), None) => measured(eta.get_ref().0, k.get_ref().0),
            (None, (None, None), Some(color)) => {
                let edge = self.edge.as_ref().map_or(Rgb::WHITE, |e| e.get_ref().0);
                if let (true, Some(given)) = (edge.max_component() > 1.0, &self.edge) {
                    return Err(Problem::at(given.span(), "expected numbers of at most 1"));
                }
                let color = find.color(color)?;
                Ok(MetalColor::Colored { color, edge })
            }
            (None, (Some(one), None) | (None, Some(one)), None) => {
                Err(Problem::at(one.span(), "`eta` and `k` go together").with_help(HELP))
            }
            (None, (None, None), None) => Err(Problem {
                span: None,
                message: "a metal needs a colour".into(),
                help: Some(HELP.into()),
            }),
            (_, (eta, k), color) => {
                let span = color.as_ref().map(Spanned::span);
                let span = span.or_else(|| eta.as_ref().or(k.as_ref()).map(Spanned::span));
                Err(Problem {
                    span,
                    message: "the metal is given twice".into(),
                    help: Some(HELP.into()),
                })
            }
        }
    }
}

/// The reflectance of a metal.
#[derive(Clone, Copy, Debug)]
pub enum MetalColor {
    Measured {
        reflectance: Reflectance,
        /// Multiplies it.
        tint: Color,
    },
    Colored {
        color: Color,
        /// See [`Reflectance::colored`].
        edge: Rgb,
    },
}

#[derive(Clone, Copy, Debug)]
pub struct Metal {
    pub color: MetalColor,
    /// Perceived, from 0 to 1.
    pub roughness: Scalar,
    /// From 0 to 1.
    pub anisotropy: f32,
    pub distribution: Distribution,
}

impl Metal {
    /// The reflectance at a point, and what it is multiplied by.
    fn reflectance(&self, textures: &Textures<'_>, at: &TexturePoint) -> (Reflectance, Rgb) {
        match &self.color {
            MetalColor::Measured { reflectance, tint } => (*reflectance, textures.color(tint, at)),
            MetalColor::Colored { color, edge } => (Reflectance::colored(textures.color(color, at), *edge), Rgb::WHITE),
        }
    }

    /// The colour that may vary over the surface.
    fn color(&self) -> &Color {
        match &self.color {
            MetalColor::Measured { tint, .. } => tint,
            MetalColor::Colored { color, .. } => color,
        }
    }
}

impl MaterialKind for Metal {
    fn whitted_terms(&self, textures: &Textures<'_>, at: &TexturePoint) -> WhittedTerms {
        let (reflectance, tint) = self.reflectance(textures, at);
        WhittedTerms {
            reflect: reflectance.normal() * tint,
            ..WhittedTerms::default()
        }
    }

    fn has_lobes(&self) -> bool {
        false
    }

    fn bsdf(&self, textures: &Textures<'_>, at: &TexturePoint) -> Bsdf {
        let roughness = textures.scalar(&self.roughness, at).clamp(0.0, 1.0);
        let (reflectance, tint) = self.reflectance(textures, at);
        match self.distribution {
            Distribution::Ggx => {
                let facets = Ggx::from_roughness(roughness, self.anisotropy);
                Bsdf::Conductor(Conductor::tinted(facets, reflectance, tint))
            }
            Distribution::Beckmann => {
                let facets = Beckmann::from_roughness(roughness, self.anisotropy);
                Bsdf::BeckmannConductor(Conductor::tinted(facets, reflectance, tint))
            }
        }
    }

    fn batch_kind(&self) -> BatchKind {
        let is_smooth = matches!(self.roughness, Scalar::Constant(r) if Ggx::from_roughness(r, 0.0).is_smooth());
        if self.anisotropy > 0.0 || is_smooth || self.distribution != Distribution::Ggx {
            BatchKind::Alone
        } else {
            BatchKind::Metal
        }
    }

    fn max_reflectance(&self, textures: &Textures<'_>) -> f32 {
        textures.max_value(self.color())
    }

    fn is_spatially_varying(&self) -> bool {
        let is_constant = self.roughness.is_constant() && self.color().is_constant();
        !is_constant || self.anisotropy > 0.0
    }

    fn convert_colors(&mut self, space: WorkingSpace) {
        match &mut self.color {
            MetalColor::Measured { reflectance, tint } => {
                *reflectance = reflectance.converted(|c| space.from_rec709(c));
                tint.convert(space);
            }
            MetalColor::Colored { color, edge } => {
                color.convert(space);
                *edge = space.from_rec709(*edge);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measured_metals_have_the_colors_that_one_sees() {
        let color = |preset: Preset| {
            let [eta, k] = preset.index().map(Rgb::from_array);
            Reflectance::Measured { eta, k }.normal()
        };
        let gold = color(Preset::Gold);
        assert!(gold.r > 0.9 && gold.r > gold.g && gold.g > 1.5 * gold.b, "{gold:?}");
        let copper = color(Preset::Copper);
        assert!(
            copper.r > 0.85 && copper.r > copper.g && copper.g > copper.b,
            "{copper:?}"
        );
        let silver = color(Preset::Silver);
        assert!(silver.r > 0.95 && silver.b > 0.9, "{silver:?}");
        for gray in [
            Preset::Aluminium,
            Preset::Chromium,
            Preset::Iron,
            Preset::Nickel,
            Preset::Titanium,
        ] {
            let color = color(gray);
            assert!((color.r - color.b).abs() < 0.13 && color.g > 0.45, "{gray:?} {color:?}");
        }
    }
}
