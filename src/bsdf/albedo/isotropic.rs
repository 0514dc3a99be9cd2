//! Facets that are as steep along one axis as along the other.
//!
//! The axes of the tables are the perceived roughness and the root of a cosine: of the direction
//! or, where all that counts is how far facets hide each other, of the direction on the stretched
//! surface ([`Ggx::stretched_cos`]).

use std::sync::OnceLock;

use super::{
    integral::{FacetGrid, direction, facets, reflected},
    table::{along, column, lerp, locate, node},
};
use crate::{bsdf::microfacet::Ggx, math::Vec3};

pub(super) const ROWS: usize = 48;
const COLUMNS: usize = 64;
const POINTS: FacetGrid = FacetGrid {
    turns: 24,
    slopes: 48,
    turn: 0.5,
    shift: 0.0,
};

/// The albedos for one roughness.
struct IsotropicRow {
    /// Albedo of facets that reflect everything, by [`Ggx::stretched_cos`].
    mirrors: [f32; COLUMNS],
    /// The mean of Schlick's term over the light that they reflect, by the cosine.
    grazing: [f32; COLUMNS],
}

static TABLE: [OnceLock<Box<IsotropicRow>>; ROWS] = [const { OnceLock::new() }; ROWS];

fn row(i: usize) -> &'static IsotropicRow {
    TABLE[i].get_or_init(|| {
        let ggx = facets(node(i, ROWS));
        let cos = |j| {
            let root: f32 = node(j, COLUMNS);
            (root * root).max(1e-4)
        };
        Box::new(IsotropicRow {
            mirrors: std::array::from_fn(|j| reflected(POINTS, &ggx, stretched_direction(&ggx, cos(j)))[0]),
            grazing: std::array::from_fn(|j| reflected(POINTS, &ggx, direction(cos(j)))[1]),
        })
    })
}

/// The direction whose [`Ggx::stretched_cos`] is `t`.
fn stretched_direction(ggx: &Ggx, t: f32) -> Vec3 {
    let a = ggx.alpha.x;
    let cos = t * a / (1.0 - t * t + t * t * a * a).sqrt();
    direction(cos.min(1.0))
}

#[inline]
fn between(roughness: f32, table: impl Fn(&'static IsotropicRow) -> &'static [f32; COLUMNS], column: f32) -> f32 {
    let (i, f) = locate(roughness, ROWS);
    lerp(along(table(row(i)), column), along(table(row(i + 1)), column), f)
}

/// Albedo of facets that reflect everything, by roughness and [`Ggx::stretched_cos`].
#[inline]
pub(super) fn mirrors_at(roughness: f32, stretched_cos: f32) -> f32 {
    between(roughness, |r| &r.mirrors, column(stretched_cos))
}

#[inline]
pub(super) fn mirrors(ggx: &Ggx, wo: Vec3) -> f32 {
    mirrors_at(ggx.alpha.x.sqrt(), ggx.stretched_cos(wo))
}

/// The mean of Schlick's term over the light that facets reflect, by roughness and cosine.
#[inline]
pub(super) fn grazing_at(roughness: f32, cos: f32) -> f32 {
    between(roughness, |r| &r.grazing, column(cos))
}

#[inline]
pub(super) fn grazing(ggx: &Ggx, wo: Vec3) -> f32 {
    grazing_at(ggx.alpha.x.sqrt(), wo.z.abs())
}
