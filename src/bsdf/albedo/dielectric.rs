//! The albedo of clear facets: reflection and transmission together.

use std::sync::OnceLock;

use super::{
    integral::{FacetGrid, direction, facets, masking, mean_over_facets, reflected},
    isotropic,
    table::{along, column, lerp, locate, node},
};
use crate::{
    bsdf::{
        fresnel,
        microfacet::{Facets, Ggx},
    },
    math::{Vec3, exponential},
};

/// Slices by index, even in the root of its logarithm: denser towards 1, where no boundary is.
const SLICES: usize = 48;
const ROWS: usize = 48;
const COLUMNS: usize = 64;
/// The highest index of the table; the lowest is its inverse. Beyond them a little light is lost.
const MAX_INDEX: f32 = 4.0;
const POINTS: FacetGrid = FacetGrid {
    turns: 32,
    slopes: 64,
    turn: 0.5,
    shift: 0.618_034,
};
/// A margin that keeps all values above the exact albedo: towards the denser side, and towards the
/// thinner one, where some facets transmit nothing.
const MARGIN: [ClearAlbedo; 2] = [
    ClearAlbedo {
        fresnel: 0.001,
        passing: 0.004,
    },
    ClearAlbedo {
        fresnel: 0.0019,
        passing: 0.004,
    },
];

/// Albedo of clear facets, by reflection and by transmission together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearAlbedo {
    /// The albedo with Fresnel's equations.
    pub fresnel: f32,
    /// The albedo where all light passes that can.
    pub passing: f32,
}

/// The albedos for one index of refraction and one roughness, by the square root of the cosine,
/// relative to the albedo of mirrors: at grazing angles everything is reflected.
struct DielectricRow {
    fresnel: [f32; COLUMNS],
    /// For indices below 1 without the part of mirrors, which is added after interpolation.
    passing: [f32; COLUMNS],
}

/// The albedos of clear facets of a distribution.
pub struct ClearTable([[OnceLock<Box<DielectricRow>>; ROWS]; SLICES]);

impl ClearTable {
    /// One whose rows are integrated on first use.
    pub const fn empty() -> Self {
        Self([const { [const { OnceLock::new() }; ROWS] }; SLICES])
    }
}

static GGX: ClearTable = ClearTable::empty();

/// Facets of clear boundaries.
pub trait ClearFacets: Facets {
    /// The albedos of clear facets of this distribution.
    fn table() -> &'static ClearTable;

    /// The albedo of these facets if they are even and reflect all light, seen from `wo`. Margins cover its error.
    fn even_mirrors(&self, wo: Vec3) -> f32;
}

impl ClearFacets for Ggx {
    fn table() -> &'static ClearTable {
        &GGX
    }

    fn even_mirrors(&self, wo: Vec3) -> f32 {
        isotropic::even_mirrors(self, wo)
    }
}

fn eta(k: usize) -> f32 {
    let x = 2.0 * node(k, SLICES) - 1.0;
    exponential::pow(MAX_INDEX, x * x.abs())
}

fn row<F: ClearFacets>(k: usize, i: usize) -> &'static DielectricRow {
    F::table().0[k][i].get_or_init(|| {
        let (eta, ggx): (f32, F) = (eta(k), facets(node(i, ROWS)));
        let mut row = DielectricRow {
            fresnel: [0.0; COLUMNS],
            passing: [0.0; COLUMNS],
        };
        for j in 0..COLUMNS {
            let root: f32 = node(j, COLUMNS);
            let wo = direction((root * root).max(1e-3));
            let [shared, passing] = mean_over_facets(POINTS, &ggx, wo, |h| {
                let part = fresnel::dielectric(wo.dot(h), eta);
                let passed = fresnel::refract(wo, h, eta);
                let all_of_it = passed
                    .and_then(|wi| ggx.transmission(wo, wi, eta))
                    .map_or(0.0, |f| f.masking);
                let reflected = masking(&ggx, wo, h);
                let passing = if part < 1.0 { all_of_it } else { reflected };
                [part * reflected + (1.0 - part) * all_of_it, passing]
            });
            let mirrors = reflected(POINTS, &ggx, wo)[0];
            row.fresnel[j] = shared - mirrors;
            row.passing[j] = if eta < 1.0 { passing - mirrors } else { passing };
        }
        Box::new(row)
    })
}

/// The albedo of clear facets seen from `wo`; `eta` is the index on the other side over the one on
/// the side of `wo`. The facets are even, or taken for it.
pub fn clear<F: ClearFacets>(ggx: &F, wo: Vec3, index: f32) -> ClearAlbedo {
    if ggx.is_smooth() {
        return ClearAlbedo {
            fresnel: 1.0,
            passing: 1.0,
        };
    }
    let log = exponential::ln(index) / exponential::ln(MAX_INDEX);
    let (k, f) = locate(0.5 + 0.5 * log.abs().sqrt().copysign(log), SLICES);
    let (i, g) = locate(ggx.alpha().x.sqrt(), ROWS);
    let column = column(wo.z.abs());
    let mirrors = ggx.even_mirrors(wo);
    let at = |k: usize| {
        let (a, b) = (row::<F>(k, i), row::<F>(k, i + 1));
        let over = if k < SLICES / 2 { mirrors } else { 0.0 };
        ClearAlbedo {
            fresnel: mirrors + lerp(along(&a.fresnel, column), along(&b.fresnel, column), g),
            passing: over + lerp(along(&a.passing, column), along(&b.passing, column), g),
        }
    };
    let (a, b) = (at(k), at(k + 1));
    let above = MARGIN[usize::from(index < 1.0)];
    ClearAlbedo {
        fresnel: (lerp(a.fresnel, b.fresnel, f) + above.fresnel).min(1.0),
        passing: (lerp(a.passing, b.passing, f) + above.passing).min(1.0),
    }
}
