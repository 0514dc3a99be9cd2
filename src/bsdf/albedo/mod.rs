//! Tabulated albedos of rough surfaces, for multiple scattering and for layers.
//!
//! The facets of [`super::microfacet`] scatter once; what would bounce between them is lost, up to
//! two thirds of the light. Divided by the albedo of white facets, a lobe loses nothing: it is as
//! strong as all bounces together, in the shape of the first. The same albedos share light out
//! between layers. Source: Turquin, "Practical multiple scattering compensation for microfacet
//! models", 2019; Kulla and Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH
//! 2017 course.
//!
//! Tables are linear between their nodes. A row is integrated on first use, in a few milliseconds,
//! always to the same bits. What they say is never less than the truth, so that no light is gained,
//! and more by no more than a hundredth, two of brushed facets at grazing angles (tested).

use super::{fresnel, microfacet::Ggx};
use crate::math::{Vec2, Vec3};

mod anisotropic;
mod dielectric;
mod isotropic;
mod sheen;

pub use dielectric::{ClearAlbedo, clear};
pub use sheen::raw_sheen;

/// What is added to a table so that it is never less than the truth: to those of facets, even and
/// brushed, and to the light that they reflect at grazing angles.
const MARGIN: [f32; 2] = [0.001, 0.0035];
const ANISOTROPIC_MARGIN: [f32; 2] = [0.004, 0.009];

/// Between which of `nodes` nodes, even from 0 to 1, `v` lies, and where between them.
#[inline]
fn locate(v: f32, nodes: usize) -> (usize, f32) {
    let v = v.clamp(0.0, 1.0) * (nodes - 1) as f32;
    let i = (v as usize).min(nodes - 2);
    (i, v - i as f32)
}

fn node(i: usize, nodes: usize) -> f32 {
    i as f32 / (nodes - 1) as f32
}

#[inline]
fn lerp(a: f32, b: f32, f: f32) -> f32 {
    a * (1.0 - f) + b * f
}

/// Linear between the nodes of `row`, even from 0 to 1.
#[inline]
fn along(row: &[f32], v: f32) -> f32 {
    let (i, f) = locate(v, row.len());
    lerp(row[i], row[i + 1], f)
}

/// A direction of the cosine `cos`.
fn direction(cos: f32) -> Vec3 {
    Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos)
}

/// The facets of a row of a table of roughness: those of the least rows are smoother than any
/// surface is.
fn facets(roughness: f32) -> Ggx {
    let roughness = roughness.max(0.02);
    Ggx {
        alpha: Vec2::splat(roughness * roughness),
    }
}

/// Where a cosine is on its axis, which is denser towards grazing ones.
#[inline]
fn column(cos: f32) -> f32 {
    cos.sqrt()
}

/// The points of an integral over facets.
#[derive(Clone, Copy)]
struct FacetGrid {
    turns: usize,
    slopes: usize,
    /// The part of a turn to integrate over: a half where the other is its mirror image.
    turn: f32,
    /// By how much of a step the slopes of each turn lie beside those of the one before: where the
    /// integrand leaps, points in rank and file would be all wrong together.
    shift: f32,
}

/// The mean of `f` over the facets that are seen from `wo`.
fn mean_over_facets<const K: usize>(points: FacetGrid, ggx: &Ggx, wo: Vec3, f: impl Fn(Vec3) -> [f32; K]) -> [f32; K] {
    let mut sum = [0.0_f64; K];
    let mut all = 0.0_f64;
    for i in 0..points.turns {
        for j in 0..points.slopes {
            // Denser towards the steep facets, which lose light.
            let q = (j as f32 + (0.5 + points.shift * i as f32).fract()) / points.slopes as f32;
            let turn = points.turn * (i as f32 + 0.5) / points.turns as f32;
            let weight = f64::from(q * q);
            all += weight;
            let values = f(ggx.sample_normal(wo, Vec2::new(turn, 1.0 - q * q * q)));
            for (sum, v) in sum.iter_mut().zip(values) {
                *sum += f64::from(v) * weight;
            }
        }
    }
    sum.map(|s| (s / all) as f32)
}

/// The part of the light that a facet `h` reflects, if all, that leaves the surface.
fn masking(ggx: &Ggx, wo: Vec3, h: Vec3) -> f32 {
    ggx.reflection(wo, fresnel::reflect(wo, h)).map_or(0.0, |f| f.masking)
}

/// The albedo of facets that reflect everything, and the mean of Schlick's term over the light that
/// they reflect.
fn reflected(points: FacetGrid, ggx: &Ggx, wo: Vec3) -> [f32; 2] {
    let [all, grazing] = mean_over_facets(points, ggx, wo, |h| {
        let masking = masking(ggx, wo, h);
        [masking, masking * fresnel::schlick_term(wo.dot(h))]
    });
    [all, grazing / all]
}

/// The albedo of facets that reflect all light, seen from `wo`.
#[inline]
pub fn mirrors(ggx: &Ggx, wo: Vec3) -> f32 {
    if ggx.is_smooth() {
        1.0
    } else if ggx.is_isotropic() {
        (isotropic::mirrors(ggx, wo) + MARGIN[0]).min(1.0)
    } else {
        (anisotropic::mirrors(ggx, wo) + ANISOTROPIC_MARGIN[0]).min(1.0)
    }
}

/// The albedo of facets that reflect as Schlick says, seen from `wo`, as weights of the reflectance
/// at normal incidence and of the one at grazing incidence: the sum is [`mirrors`].
#[inline]
pub fn schlick(ggx: &Ggx, wo: Vec3) -> [f32; 2] {
    if ggx.is_smooth() {
        let grazing = fresnel::schlick_term(wo.z.abs());
        return [1.0 - grazing, grazing];
    }
    let (all, part, above) = if ggx.is_isotropic() {
        (isotropic::mirrors(ggx, wo), isotropic::grazing(ggx, wo), MARGIN)
    } else {
        (
            anisotropic::mirrors(ggx, wo),
            anisotropic::grazing(ggx, wo),
            ANISOTROPIC_MARGIN,
        )
    };
    let grazing = all * part + above[1];
    let all = (all + above[0]).min(1.0);
    let grazing = grazing.min(all);
    [all - grazing, grazing]
}

/// The mean of [`schlick`] over all directions, weighted by their cosine: what a surface of light
/// sees of it.
#[inline]
pub fn schlick_mean(ggx: &Ggx) -> [f32; 2] {
    if ggx.is_isotropic() {
        isotropic::schlick_mean(ggx)
    } else {
        anisotropic::schlick_mean(ggx)
    }
}

/// The mean of [`schlick`] over so many directions by tilt and by turn; a quarter of the turns is
/// all where there is but one.
fn mean_over_directions(ggx: &Ggx, tilts: usize, turns: usize) -> [f32; 2] {
    let mut sum = [0.0_f64; 2];
    for i in 0..tilts {
        // Denser towards grazing directions; the cosine and the step of its square make the weight.
        let q = (i as f32 + 0.5) / tilts as f32;
        let cos = q * q;
        let weight = f64::from(4.0 * q * cos);
        let sin = (1.0 - cos * cos).sqrt();
        for j in 0..turns {
            let turn = std::f32::consts::FRAC_PI_2 * (j as f32 + 0.5) / turns as f32;
            let (s, c) = crate::math::trig::sin_cos(turn);
            for (sum, v) in sum.iter_mut().zip(schlick(ggx, Vec3::new(sin * c, sin * s, cos))) {
                *sum += f64::from(v) * weight;
            }
        }
    }
    sum.map(|s| (s / (tilts * turns) as f64) as f32)
}
