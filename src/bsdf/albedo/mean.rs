//! The mean albedo of facets that reflect as Schlick says, over all directions.

use std::{f32::consts::FRAC_PI_2, sync::OnceLock};

use super::{
    anisotropic::{self, NODES},
    isotropic::{ROWS, RowPlace},
    schlick::FacetAlbedo,
    table::node,
};
use crate::{
    bsdf::microfacet::Ggx,
    math::{Vec3, trig},
};

/// By the nodes of the table of isotropic facets.
static ISOTROPIC: [OnceLock<[f32; 2]>; ROWS] = [const { OnceLock::new() }; ROWS];
/// By the nodes of the table of anisotropic facets.
static ANISOTROPIC: [[OnceLock<[f32; 2]>; NODES[1]]; NODES[0]] =
    [const { [const { OnceLock::new() }; NODES[1]] }; NODES[0]];

/// The mean of [`FacetAlbedo::schlick`] over all directions, weighted by their cosine: what a surface of light
/// sees of the facets `ggx`, which `albedo` is of.
#[inline]
pub fn schlick_mean(albedo: FacetAlbedo, ggx: &Ggx) -> [f32; 2] {
    match albedo {
        FacetAlbedo::Isotropic(place) => place.between(isotropic_node),
        FacetAlbedo::Smooth => RowPlace::of_facets(ggx).between(isotropic_node),
        FacetAlbedo::Anisotropic => anisotropic_mean(ggx),
    }
}

fn isotropic_node(i: usize) -> [f32; 2] {
    *ISOTROPIC[i].get_or_init(|| mean_over_directions(&Ggx::from_roughness(node(i, ROWS), 0.0), 64, 1))
}

fn anisotropic_mean(ggx: &Ggx) -> [f32; 2] {
    let mean = |i: usize, j: usize| {
        *ANISOTROPIC[i][j].get_or_init(|| mean_over_directions(&anisotropic::facets(i, j), 32, 16))
    };
    [0, 1].map(|k| anisotropic::between(ggx, mean, |m| m[k]))
}

/// The mean of [`FacetAlbedo::schlick`] over so many directions by tilt and by turn; a quarter of the turns is
/// all where there is but one.
fn mean_over_directions(ggx: &Ggx, tilts: usize, turns: usize) -> [f32; 2] {
    let albedo = FacetAlbedo::new(ggx);
    let mut sum = [0.0_f64; 2];
    for i in 0..tilts {
        // Denser towards grazing directions; the cosine and the step of its square make the weight.
        let q = (i as f32 + 0.5) / tilts as f32;
        let cos = q * q;
        let weight = f64::from(4.0 * q * cos);
        let sin = (1.0 - cos * cos).sqrt();
        for j in 0..turns {
            let turn = FRAC_PI_2 * (j as f32 + 0.5) / turns as f32;
            let (s, c) = trig::sin_cos(turn);
            for (sum, v) in sum
                .iter_mut()
                .zip(albedo.schlick(ggx, Vec3::new(sin * c, sin * s, cos)))
            {
                *sum += f64::from(v) * weight;
            }
        }
    }
    sum.map(|s| (s / (tilts * turns) as f64) as f32)
}
