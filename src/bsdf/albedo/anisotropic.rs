//! Facets that are steeper along one axis than along the other: how far they are from even ones.
//!
//! The albedo is about that of even facets of the same mean square alpha, seen from where they hide
//! each other as far; and what is reflected at grazing angles about that of even facets as steep as
//! these are towards the viewer. A table has the rest, for each pair of a roughness and of a ratio
//! of the alphas by the direction.

use std::sync::OnceLock;

use super::{
    brushed::{self, azimuth, azimuth_vector, lookup},
    integral::{FacetGrid, reflected},
    isotropic,
    table::{column, cos_of, node},
};
use crate::{
    bsdf::microfacet::Ggx,
    math::{Vec2, Vec3},
};

/// Nodes by roughness, and by the root of the ratio of the smaller alpha to the larger one.
pub(super) const NODES: [usize; 2] = [12, 8];
/// Nodes by the root of a cosine, and by turn: of the albedo, and of what is grazing.
const MIRRORS: [usize; 2] = [24, 8];
const GRAZING: [usize; 2] = [16, 16];
const POINTS: FacetGrid = FacetGrid {
    turns: 48,
    slopes: 48,
    turn: 1.0,
    shift: 0.0,
};

type Mirrors = [[f32; MIRRORS[1]]; MIRRORS[0]];
type Grazing = [[f32; GRAZING[1]]; GRAZING[0]];

/// The corrections of one node; each table is integrated on first use.
struct AnisotropicNode {
    mirrors: OnceLock<Box<Mirrors>>,
    grazing: OnceLock<Box<Grazing>>,
}

static TABLE: [[AnisotropicNode; NODES[1]]; NODES[0]] = [const {
    [const {
        AnisotropicNode {
            mirrors: OnceLock::new(),
            grazing: OnceLock::new(),
        }
    }; NODES[1]]
}; NODES[0]];

/// Facets, turned so that they are steeper along x, and a direction with them.
struct AlignedFacets {
    ggx: Ggx,
    wo: Vec3,
}

impl AlignedFacets {
    fn new(ggx: &Ggx, wo: Vec3) -> Self {
        let (alpha, wo) = brushed::aligned(ggx.alpha, wo);
        Self { ggx: Ggx { alpha }, wo }
    }

    /// The albedo as that of even facets.
    fn mirrors(&self) -> f32 {
        isotropic::RowPlace::of_roughness(brushed::roughness(self.ggx.alpha))
            .rows()
            .mirrors(self.ggx.stretched_cos(self.wo))
    }

    /// The mean of Schlick's term as that of even facets.
    fn grazing(&self) -> f32 {
        let across = Vec2::new(self.wo.x, self.wo.y);
        let length = across.length();
        let alpha = if length > 0.0 {
            (across * self.ggx.alpha).length() / length
        } else {
            (0.5 * self.ggx.alpha.length_squared()).sqrt()
        };
        isotropic::RowPlace::of_roughness(alpha.sqrt())
            .rows()
            .grazing(self.wo.z)
    }
}

/// The facets of a node.
pub(super) fn facets(i: usize, j: usize) -> Ggx {
    brushed::facets(NODES, i, j)
}

fn mirrors_of(i: usize, j: usize) -> &'static Mirrors {
    TABLE[i][j].mirrors.get_or_init(|| {
        let ggx = facets(i, j);
        let [columns, turns] = MIRRORS;
        let table = std::array::from_fn(|k| {
            std::array::from_fn(|l| {
                let wo = brushed::seen_from(ggx.alpha, azimuth_vector(node(l, turns)), cos_of(k, columns));
                reflected(POINTS, &ggx, wo)[0] - AlignedFacets { ggx, wo }.mirrors()
            })
        });
        Box::new(table)
    })
}

fn grazing_of(i: usize, j: usize) -> &'static Grazing {
    TABLE[i][j].grazing.get_or_init(|| {
        let ggx = facets(i, j);
        let [columns, turns] = GRAZING;
        let table = std::array::from_fn(|k| {
            let cos = cos_of(k, columns);
            let sin = (1.0 - cos * cos).sqrt();
            std::array::from_fn(|l| {
                // Denser across the axis along which facets are steep.
                let wo = (azimuth_vector(node(l, turns) * node(l, turns)) * sin).extend(cos);
                reflected(POINTS, &ggx, wo)[1] - AlignedFacets { ggx, wo }.grazing()
            })
        });
        Box::new(table)
    })
}

/// Linear between the four nodes about `ggx`.
pub(super) fn between<T>(ggx: &Ggx, of: impl Fn(usize, usize) -> T, value: impl Fn(T) -> f32) -> f32 {
    brushed::between(ggx.alpha, NODES, of, value)
}

/// See [`super::mirrors`].
pub(super) fn mirrors(ggx: &Ggx, wo: Vec3) -> f32 {
    let facets = AlignedFacets::new(ggx, wo);
    let s = brushed::stretched(facets.ggx.alpha, facets.wo);
    let (column, turn) = (column(s.z), azimuth(s.x, s.y));
    facets.mirrors() + between(&facets.ggx, mirrors_of, |table| lookup(table, column, turn))
}

/// The mean of Schlick's term over the light that is reflected.
pub(super) fn grazing(ggx: &Ggx, wo: Vec3) -> f32 {
    let facets = AlignedFacets::new(ggx, wo);
    let (column, turn) = (column(facets.wo.z), azimuth(facets.wo.x, facets.wo.y).sqrt());
    let off = between(&facets.ggx, grazing_of, |table| lookup(table, column, turn));
    (facets.grazing() + off).clamp(0.0, 1.0)
}
