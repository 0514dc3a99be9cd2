//! Microfacet model with the distribution of Beckmann: slopes are normally distributed.
//!
//! Masking and shadowing are height-correlated Smith, without approximation, and the visible normals are sampled. Its highlights
//! have no tails. All directions are in the shading frame, whose normal is z.
//!
//! Source: Beckmann and Spizzichino, "The Scattering of Electromagnetic Waves from Rough Surfaces", 1963; Walter et al.,
//! "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007, doi:10.2312/EGWR/EGSR07/195-206; Heitz, "Understanding the
//! Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2), 2014; for visible normals Heitz and d'Eon, "Importance
//! Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals", CGF 33(4), 2014, doi:10.1111/cgf.12417.

use std::f32::consts::{FRAC_2_SQRT_PI, PI};

use super::microfacet::{Facet, Facets, Refraction};
use crate::math::{Vec2, Vec3, erfcx, exponential::exp};

/// The steepest slope, on the surface that is stretched to a roughness of 1: the part of those beyond is less than the distance of
/// two numbers in single precision.
const MAX_SLOPE: f32 = 4.5;

/// The most steps of the search for a slope.
const MAX_STEPS: u32 = 24;

/// The Beckmann distribution of facet normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beckmann {
    /// Roughness along the tangent and along the bitangent: the root of 2 times the standard deviation of the slopes. From
    /// [`Ggx::MIN_ALPHA`](super::microfacet::Ggx::MIN_ALPHA) to 1; 0 where smooth.
    pub alpha: Vec2,
}

/// The projected area of facets, per area of the surface, seen from a direction.
struct ProjectedArea {
    /// The area of the visible facets less that of the surface: Smith's lambda times the cosine.
    excess: f32,
    /// The area of all facets that face the direction: 1 + lambda times the cosine.
    all: f32,
}

impl ProjectedArea {
    /// Seen at a cosine and a sine, on the surface that is stretched to a roughness of 1; both may be scaled.
    #[inline]
    fn new(cos: f32, sin: f32) -> Self {
        let cot = cos / sin;
        let excess = if cot < f32::INFINITY {
            let tail = 0.5 * FRAC_2_SQRT_PI * sin - cos * erfcx(cot);
            (0.5 * exp(-cot * cot) * tail).max(0.0)
        } else {
            0.0
        };
        Self {
            excess,
            all: cos + excess,
        }
    }
}

/// Twice the projected area of the facets with slopes above `slope` towards the viewer, and minus its derivative, on the surface
/// that is stretched to a roughness of 1.
#[inline]
fn area_above(slope: f32, cos: f32, sin: f32) -> (f32, f32) {
    let bell = exp(-slope * slope);
    let tail = bell * erfcx(slope.abs());
    let tail = if slope < 0.0 { 2.0 - tail } else { tail };
    let area = cos * tail + 0.5 * FRAC_2_SQRT_PI * sin * bell;
    (area, FRAC_2_SQRT_PI * bell * (cos + slope * sin))
}

/// The slope towards a viewer at a cosine and a sine below which the part `u` of the projected area of the visible facets is.
fn visible_slope(u: f32, cos: f32, sin: f32) -> f32 {
    let (mut low, mut high) = ((-cos / sin).max(-MAX_SLOPE), MAX_SLOPE);
    let all = area_above(low, cos, sin).0;
    let wanted = (1.0 - u) * all;
    let mut slope = 0.5 * (low.max(-1.0) + 1.0);
    for _ in 0..MAX_STEPS {
        let (area, density) = area_above(slope, cos, sin);
        let off = area - wanted;
        if off.abs() <= f32::EPSILON * all {
            break;
        }
        if off > 0.0 {
            low = slope;
        } else {
            high = slope;
        }
        let next = slope + off / density;
        slope = if next > low && next < high {
            next
        } else {
            0.5 * (low + high)
        };
    }
    slope
}

impl Beckmann {
    #[inline]
    fn area(&self, w: Vec3) -> ProjectedArea {
        ProjectedArea::new(w.z.abs(), (Vec2::new(w.x, w.y) * self.alpha).length())
    }

    /// The fraction of the light that other facets do not shadow; see [`Facet::masking`].
    #[inline]
    fn masking(out: &ProjectedArea, wo: Vec3, wi: Vec3, into: &ProjectedArea) -> f32 {
        let lit = out.all * wi.z.abs();
        lit / (lit + into.excess * wo.z)
    }

    /// Area of facets with the unit normal `h`, per area and steradian.
    pub fn density(&self, h: Vec3) -> f32 {
        let s = Vec2::new(h.x, h.y) / self.alpha;
        let cos2 = h.z * h.z;
        let bell = exp(-s.length_squared() / cos2);
        if bell > 0.0 {
            bell / (PI * self.alpha.x * self.alpha.y * cos2 * cos2)
        } else {
            0.0
        }
    }

    /// The direction in which the surface that is stretched to a roughness of 1 sees `w`.
    pub fn stretched(&self, w: Vec3) -> Vec3 {
        (w * self.alpha.extend(1.0)).normalize()
    }
}

impl Facets for Beckmann {
    fn with_alpha(alpha: Vec2) -> Self {
        Self { alpha }
    }

    fn alpha(&self) -> Vec2 {
        self.alpha
    }

    fn sample_normal(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let w = self.stretched(wo);
        let sin = Vec2::new(w.x, w.y).length();
        let towards = if sin > 0.0 { Vec2::new(w.x, w.y) / sin } else { Vec2::X };
        // The halves of the first number are mirror images, as those of other distributions.
        let (across, along) = (visible_slope(u.x, 1.0, 0.0), visible_slope(u.y, w.z, sin));
        let slopes = (towards * along + towards.perp() * across) * self.alpha;
        slopes.extend(1.0).normalize()
    }

    fn reflection(&self, wo: Vec3, wi: Vec3) -> Option<Facet> {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return None;
        }
        let h = (wo + wi).try_normalize()?;
        let cos = wo.dot(h);
        let (out, into) = (self.area(wo), self.area(wi));
        (cos > 0.0).then(|| Facet {
            cos,
            pdf: self.density(h) / (4.0 * out.all),
            masking: Self::masking(&out, wo, wi, &into),
        })
    }

    fn transmission(&self, wo: Vec3, wi: Vec3, eta: f32) -> Option<Facet> {
        let Refraction { h, cos, spread } = Refraction::new(wo, wi, eta)?;
        let (out, into) = (self.area(wo), self.area(wi));
        Some(Facet {
            cos,
            pdf: self.density(h) * cos / out.all * spread,
            masking: Self::masking(&out, wo, wi, &into),
        })
    }
}
