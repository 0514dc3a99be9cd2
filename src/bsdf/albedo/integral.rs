//! Integrals over facets, from which tables are made.

use crate::{
    bsdf::{fresnel, microfacet::Facets},
    math::{Vec2, Vec3},
};

/// A direction of the cosine `cos`.
pub(super) fn direction(cos: f32) -> Vec3 {
    Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos)
}

/// The facets of a row of a table of roughness: those of the least rows are smoother than any
/// surface is.
pub(super) fn facets<F: Facets>(roughness: f32) -> F {
    let roughness = roughness.max(0.02);
    F::with_alpha(Vec2::splat(roughness * roughness))
}

/// The points of an integral over facets.
#[derive(Clone, Copy)]
pub(super) struct FacetGrid {
    pub turns: usize,
    pub slopes: usize,
    /// The part of a turn to integrate over: a half where the other is its mirror image.
    pub turn: f32,
    /// By how much of a step the slopes of each turn lie beside those of the one before: where the
    /// integrand leaps, points in rank and file would be all wrong together.
    pub shift: f32,
}

/// The mean of `f` over the facets that are seen from `wo`.
pub(super) fn mean_over_facets<const K: usize>(
    points: FacetGrid,
    facets: &impl Facets,
    wo: Vec3,
    f: impl Fn(Vec3) -> [f32; K],
) -> [f32; K] {
    let mut sum = [0.0_f64; K];
    let mut all = 0.0_f64;
    for i in 0..points.turns {
        for j in 0..points.slopes {
            // Denser towards the steep facets, which lose light.
            let q = (j as f32 + (0.5 + points.shift * i as f32).fract()) / points.slopes as f32;
            let turn = points.turn * (i as f32 + 0.5) / points.turns as f32;
            let weight = f64::from(q * q);
            all += weight;
            let values = f(facets.sample_normal(wo, Vec2::new(turn, 1.0 - q * q * q)));
            for (sum, v) in sum.iter_mut().zip(values) {
                *sum += f64::from(v) * weight;
            }
        }
    }
    sum.map(|s| (s / all) as f32)
}

/// The part of the light that a facet `h` reflects, if all, that leaves the surface.
pub(super) fn masking(facets: &impl Facets, wo: Vec3, h: Vec3) -> f32 {
    facets
        .reflection(wo, fresnel::reflect(wo, h))
        .map_or(0.0, |f| f.masking)
}

/// The albedo of facets that reflect everything, and the mean of Schlick's term over the light that
/// they reflect.
pub(super) fn reflected(points: FacetGrid, facets: &impl Facets, wo: Vec3) -> [f32; 2] {
    let [all, grazing] = mean_over_facets(points, facets, wo, |h| {
        let masking = masking(facets, wo, h);
        [masking, masking * fresnel::schlick_term(wo.dot(h))]
    });
    [all, grazing / all]
}
