//! The albedo of facets with the distribution of Beckmann that reflect all light.
//!
//! Even facets have a table by the perceived roughness and the root of the cosine on the surface that is stretched to a
//! roughness of 1; brushed ones also by the root of the ratio of their alphas and by the turn of the viewer. Rows are
//! integrated on first use, over slopes.

use std::sync::OnceLock;

use super::{
    brushed::{self, azimuth, azimuth_vector, seen_from},
    dielectric::{ClearFacets, ClearTable},
    integral::{facets, masking},
    mirrors::MirrorFacets,
    table::{along, column, cos_of, lerp, locate, node},
};
use crate::{
    bsdf::{beckmann::Beckmann, microfacet::Facets},
    math::{Vec2, Vec3, exponential},
};

const ROWS: usize = 48;
const COLUMNS: usize = 64;
/// Nodes by roughness, and by the root of the ratio of the smaller alpha to the larger one, of brushed facets.
const NODES: [usize; 2] = [24, 8];
/// Their nodes by the root of a cosine, and by turn.
const BRUSHED: [usize; 2] = [32, 8];
/// Margins that keep the tables above the exact albedo.
const MARGIN: f32 = 0.0045;
const BRUSHED_MARGIN: f32 = 0.007;

type Row = [f32; COLUMNS];
type Brushed = [[f32; BRUSHED[1]]; BRUSHED[0]];

static EVEN_TABLE: [OnceLock<Box<Row>>; ROWS] = [const { OnceLock::new() }; ROWS];
static BRUSHED_TABLE: [[OnceLock<Box<Brushed>>; NODES[1]]; NODES[0]] =
    [const { [const { OnceLock::new() }; NODES[1]] }; NODES[0]];

/// The place of facets in the tables.
#[derive(Clone, Copy, Debug)]
pub enum BeckmannAlbedo {
    Smooth,
    /// A row, and where between it and the next one.
    Even(u8, f32),
    Brushed,
}

impl BeckmannAlbedo {
    pub fn new(facets: &Beckmann) -> Self {
        if facets.is_smooth() {
            Self::Smooth
        } else if facets.is_isotropic() {
            let (row, f) = locate(facets.alpha.x.sqrt(), ROWS);
            Self::Even(row as u8, f)
        } else {
            Self::Brushed
        }
    }

    /// The albedo of `facets`, which this is the place of, seen from `wo`; not less than the truth.
    pub fn mirrors(self, facets: &Beckmann, wo: Vec3) -> f32 {
        let above = match self {
            Self::Smooth => 0.0,
            Self::Even(..) => MARGIN,
            Self::Brushed => BRUSHED_MARGIN,
        };
        (self.interpolated(facets, wo) + above).min(1.0)
    }

    /// The same without a margin.
    fn interpolated(self, facets: &Beckmann, wo: Vec3) -> f32 {
        match self {
            Self::Smooth => 1.0,
            Self::Even(row, f) => {
                let (row, at) = (usize::from(row), column(facets.stretched(wo).z.abs()));
                lerp(along(even(row), at), along(even(row + 1), at), f)
            }
            Self::Brushed => brushed(facets, wo),
        }
    }
}

static CLEAR: ClearTable = ClearTable::empty();

impl MirrorFacets for Beckmann {
    type Albedo = BeckmannAlbedo;

    fn albedo(&self) -> BeckmannAlbedo {
        BeckmannAlbedo::new(self)
    }

    fn mirrors(&self, albedo: &BeckmannAlbedo, wo: Vec3) -> f32 {
        albedo.mirrors(self, wo)
    }
}

impl ClearFacets for Beckmann {
    fn table() -> &'static ClearTable {
        &CLEAR
    }

    fn even_mirrors(&self, wo: Vec3) -> f32 {
        BeckmannAlbedo::new(self).mirrors(self, wo)
    }
}

/// The albedo of facets that reflect all light, seen from `wo`: over so many slopes along each axis.
fn integral(facets: &Beckmann, wo: Vec3, points: usize) -> f32 {
    const STEEPEST: f32 = 4.2;
    let (mut all, mut leaves) = (0.0_f64, 0.0_f64);
    let slope = |i: usize| ((2 * i + 1) as f32 / points as f32 - 1.0) * STEEPEST;
    for i in 0..points {
        for j in 0..points {
            let s = Vec2::new(slope(i), slope(j));
            let h = (s * facets.alpha).extend(1.0).normalize();
            let cos = wo.dot(h);
            if cos <= 0.0 {
                continue;
            }
            let weight = f64::from(exponential::exp(-s.length_squared()) * cos / h.z);
            all += weight;
            leaves += weight * f64::from(masking(facets, wo, h));
        }
    }
    if all > 0.0 { (leaves / all) as f32 } else { 1.0 }
}

fn even(row: usize) -> &'static Row {
    EVEN_TABLE[row].get_or_init(|| {
        let facets: Beckmann = facets(node(row, ROWS));
        Box::new(std::array::from_fn(|k| {
            integral(&facets, seen_from(facets.alpha, Vec2::X, cos_of(k, COLUMNS)), 64)
        }))
    })
}

fn brushed_node(i: usize, j: usize) -> &'static Brushed {
    BRUSHED_TABLE[i][j].get_or_init(|| {
        let facets: Beckmann = brushed::facets(NODES, i, j);
        let [columns, turns] = BRUSHED;
        let at = |k, l| {
            let turn = azimuth_vector(node(l, turns));
            integral(&facets, seen_from(facets.alpha, turn, cos_of(k, columns)), 48)
        };
        Box::new(std::array::from_fn(|k| std::array::from_fn(|l| at(k, l))))
    })
}

fn brushed(facets: &Beckmann, wo: Vec3) -> f32 {
    let (alpha, wo) = brushed::aligned(facets.alpha, wo);
    let s = brushed::stretched(alpha, wo);
    let (column, turn) = (column(s.z), azimuth(s.x, s.y));
    brushed::between(alpha, NODES, brushed_node, |table| brushed::lookup(table, column, turn))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::albedo::integral::direction;

    fn turned(cos: f32, turn: f32) -> Vec3 {
        let sin = (1.0 - cos * cos).sqrt();
        Vec3::new(sin * libm::cosf(turn), sin * libm::sinf(turn), cos)
    }

    #[test]
    fn the_tables_say_no_less_than_the_truth_and_little_more() {
        let mut wrong = Vec::new();
        for roughness in [0.05, 0.15, 0.3, 0.41, 0.6, 0.77, 0.93, 1.0] {
            let facets = Beckmann::from_roughness(roughness, 0.0);
            for cos in [0.003, 0.03, 0.1, 0.22, 0.4, 0.7, 0.95] {
                let (is, said) = (
                    integral(&facets, direction(cos), 160),
                    facets.mirrors(&facets.albedo(), direction(cos)),
                );
                if !(-3e-4..0.0075).contains(&(said - is)) {
                    wrong.push(format!("{roughness} {cos}: {is} {said} {}", said - is));
                }
            }
        }
        assert!(wrong.is_empty(), "{}\n{}", wrong.len(), wrong.join("\n"));
    }

    #[test]
    fn the_tables_of_brushed_facets_say_no_less_than_the_truth_and_little_more() {
        let mut wrong = Vec::new();
        for (roughness, anisotropy) in [(0.1, 0.3), (0.15, 0.9), (0.5, 0.8), (0.8, 0.4)] {
            let facets = Beckmann::from_roughness(roughness, anisotropy);
            for cos in [0.01, 0.1, 0.3, 0.7, 1.0] {
                for turn in [0.0, 0.4, 1.2, 1.57] {
                    let wo = turned(cos, turn);
                    let (is, said) = (integral(&facets, wo, 160), facets.mirrors(&facets.albedo(), wo));
                    if !(-3e-4..0.017).contains(&(said - is)) {
                        wrong.push(format!(
                            "{roughness} {anisotropy} {cos} {turn}: {is} {said} {}",
                            said - is
                        ));
                    }
                }
            }
        }
        assert!(wrong.is_empty(), "{}\n{}", wrong.len(), wrong.join("\n"));
    }
}
