//! Microfacet models: what all distributions of facet normals have, and that of Trowbridge and Reitz (GGX).
//!
//! Masking and shadowing are height-correlated Smith, and the visible normals are sampled. All
//! directions are in the shading frame, whose normal is z.
//!
//! Source: Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT
//! 3(2), 2014; Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007,
//! doi:10.2312/EGWR/EGSR07/195-206; Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical
//! Caps", CGF 42(8), 2023, doi:10.1111/cgf.14867.

use std::f32::consts::PI;

use serde::Deserialize;

use super::fresnel::{reflect, refract};
use crate::math::{Vec2, Vec3, trig};

/// The distributions of facet normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Distribution {
    #[default]
    Ggx,
    Beckmann,
}

/// A distribution of facet normals with Smith's masking, whose visible normals are sampled.
pub trait Facets: Copy + std::fmt::Debug {
    /// Facets of any `alpha` along the tangent and the bitangent, also one that no surface has.
    fn with_alpha(alpha: Vec2) -> Self;

    fn alpha(&self) -> Vec2;

    /// Samples the normal of a facet that is visible from `wo`, which is above the surface.
    fn sample_normal(&self, wo: Vec3, u: Vec2) -> Vec3;

    /// The facet that reflects `wi` to `wo`, both above the surface.
    fn reflection(&self, wo: Vec3, wi: Vec3) -> Option<Facet>;

    /// The facet that refracts `wi`, below the surface, to `wo`, above it. `eta` is the index below over the one above.
    fn transmission(&self, wo: Vec3, wi: Vec3, eta: f32) -> Option<Facet>;

    /// The facets of a perceived `roughness` from 0 to 1 and an `anisotropy`, as [`Ggx::from_roughness`] has them.
    fn from_roughness(roughness: f32, anisotropy: f32) -> Self {
        Self::with_alpha(Ggx::from_roughness(roughness, anisotropy).alpha)
    }

    /// Whether the surface is perfectly smooth.
    #[inline]
    fn is_smooth(&self) -> bool {
        self.alpha().x == 0.0
    }

    /// Whether the distribution is isotropic.
    #[inline]
    fn is_isotropic(&self) -> bool {
        self.alpha().x == self.alpha().y
    }

    /// A direction that a facet seen from `wo` reflects; `None` where it would go into the surface.
    #[inline]
    fn sample_reflection(&self, wo: Vec3, u: Vec2) -> Option<Vec3> {
        let wi = reflect(wo, self.sample_normal(wo, u)).normalize();
        (wi.z > 0.0).then_some(wi)
    }

    /// A direction that a facet seen from `wo` refracts; `None` where it would stay above the surface, or cannot pass.
    #[inline]
    fn sample_transmission(&self, wo: Vec3, u: Vec2, eta: f32) -> Option<Vec3> {
        let wi = refract(wo, self.sample_normal(wo, u), eta)?;
        (wi.z < 0.0).then_some(wi)
    }
}

/// The GGX distribution of facet normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// Roughness along the tangent and along the bitangent, from [`Ggx::MIN_ALPHA`] to 1; 0 where
    /// smooth.
    pub alpha: Vec2,
}

/// The facet that scatters one direction into another.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// Cosine between `wo` and the facet's normal.
    pub cos: f32,
    /// Density of `wi`, in sr^-1, if the visible normals are sampled.
    pub pdf: f32,
    /// The fraction G2 / G1 of the light that other facets do not shadow: `f |cos| / pdf` of a
    /// lossless facet.
    pub masking: f32,
}

impl Ggx {
    /// The smallest alpha; surfaces below it are smooth.
    pub const MIN_ALPHA: f32 = 1e-3;

    /// Perfectly smooth.
    pub const SMOOTH: Self = Self { alpha: Vec2::ZERO };

    /// Facets of `alpha` along the tangent and the bitangent.
    pub fn new(alpha: Vec2) -> Self {
        if alpha.max_element() < Self::MIN_ALPHA {
            return Self::SMOOTH;
        }
        Self {
            alpha: alpha.clamp(Vec2::splat(Self::MIN_ALPHA), Vec2::ONE),
        }
    }

    /// The facets of a perceived `roughness` from 0 to 1, whose square is alpha; `anisotropy`, from
    /// 0 to 1, stretches highlights along the tangent, as glTF's KHR_materials_anisotropy has it.
    pub fn from_roughness(roughness: f32, anisotropy: f32) -> Self {
        let alpha = roughness * roughness;
        let along = alpha + (1.0 - alpha) * anisotropy * anisotropy;
        Self::new(Vec2::new(along, alpha))
    }

    /// The isotropic distribution with the same mean square alpha.
    pub fn isotropic(&self) -> Self {
        Self::new(Vec2::splat((0.5 * self.alpha.length_squared()).sqrt()))
    }

    /// Area of facets with the unit normal `h`, per area and steradian.
    #[inline(always)]
    pub fn density(&self, h: Vec3) -> f32 {
        let s = Vec2::new(h.x, h.y) / self.alpha;
        let q = s.length_squared() + h.z * h.z;
        1.0 / (PI * self.alpha.x * self.alpha.y * q * q)
    }

    /// Length of `w` where the surface is stretched until its facets are a hemisphere; `|w.z|` over
    /// it tells all about masking.
    #[inline(always)]
    fn stretched(&self, w: Vec3) -> f32 {
        let s = Vec2::new(w.x, w.y) * self.alpha;
        (s.length_squared() + w.z * w.z).sqrt()
    }

    /// Cosine of `w` where the surface is stretched until its facets are a hemisphere: `1 / (1 + 2
    /// lambda)`.
    #[inline(always)]
    pub fn stretched_cos(&self, w: Vec3) -> f32 {
        w.z.abs() / self.stretched(w)
    }

    /// Does the same as [`Facets::sample_normal`], for vectors.
    #[inline(always)]
    pub fn visible_normal(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let a = self.alpha.extend(1.0);
        let w = (wo * a).normalize();
        let (sin_phi, cos_phi) = trig::sin_cos_in_range(2.0 * PI * u.x);
        let z = (1.0 - u.y) * (1.0 + w.z) - w.z;
        let sin = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
        let h = Vec3::new(sin * cos_phi, sin * sin_phi, z) + w;
        // Facets do not face down; rounding at grazing angles may say so.
        Vec3::new(h.x * a.x, h.y * a.y, h.z.max(1e-7)).normalize()
    }

    /// Does the same as [`Facets::reflection`] for directions above the surface, with whether there is such a facet; for vectors.
    #[inline(always)]
    pub fn mirror_facet(&self, wo: Vec3, wi: Vec3) -> (Facet, bool) {
        let sum = wo + wi;
        let scale = sum.length_recip();
        let h = sum * scale;
        let cos = wo.dot(h);
        let (lo, li) = (self.stretched(wo), self.stretched(wi));
        let facet = Facet {
            cos,
            pdf: self.density(h) / (2.0 * (wo.z + lo)),
            masking: wi.z * (wo.z + lo) / (lo * wi.z + li * wo.z),
        };
        (facet, (scale < f32::INFINITY) & (scale > 0.0) & (cos > 0.0))
    }
}

/// The facet that refracts one direction into another.
pub(super) struct Refraction {
    /// Its normal, on the side of `wo`.
    pub h: Vec3,
    /// The cosine of `wo` to its normal.
    pub cos: f32,
    /// The solid angle of normals per solid angle of `wi`.
    pub spread: f32,
}

impl Refraction {
    /// The facet that refracts `wo` above the surface into `wi` below it, if there is one.
    ///
    /// Source: Walter, Marschner, Li, Torrance, "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007, equations 16
    /// and 17, doi:10.2312/EGWR/EGSR07/195-206.
    #[inline(always)]
    pub fn new(wo: Vec3, wi: Vec3, eta: f32) -> Option<Self> {
        if wo.z <= 0.0 || wi.z >= 0.0 {
            return None;
        }
        let sum = wo + wi * eta;
        let h = sum.try_normalize()?;
        let h = if h.z < 0.0 { -h } else { h };
        let (cos, cos_i) = (wo.dot(h), wi.dot(h));
        (cos > 0.0 && cos_i < 0.0).then(|| Self {
            h,
            cos,
            spread: eta * eta * -cos_i / sum.length_squared(),
        })
    }
}

impl Facets for Ggx {
    #[inline]
    fn with_alpha(alpha: Vec2) -> Self {
        Self { alpha }
    }

    #[inline]
    fn alpha(&self) -> Vec2 {
        self.alpha
    }

    #[inline]
    fn sample_normal(&self, wo: Vec3, u: Vec2) -> Vec3 {
        self.visible_normal(wo, u)
    }

    #[inline]
    fn reflection(&self, wo: Vec3, wi: Vec3) -> Option<Facet> {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return None;
        }
        let (facet, is_there) = self.mirror_facet(wo, wi);
        is_there.then_some(facet)
    }

    #[inline]
    fn transmission(&self, wo: Vec3, wi: Vec3, eta: f32) -> Option<Facet> {
        let Refraction { h, cos, spread } = Refraction::new(wo, wi, eta)?;
        let (lo, li) = (self.stretched(wo), self.stretched(wi));
        Some(Facet {
            cos,
            pdf: self.density(h) * 2.0 * cos / (wo.z + lo) * spread,
            masking: -wi.z * (wo.z + lo) / (lo * -wi.z + li * wo.z),
        })
    }
}
