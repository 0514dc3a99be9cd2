//! Cells around random points: cobbles, cracked earth, scales, flakes of paint.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `a`, `b` | number or `[r, g, b]`, scene-linear: the colours where the value is 0 and where it is 1 | | 0, 1 |
//! | `value` | `"distance"` from the nearest point, `"edge"`: how much further the second nearest is, or `"cell"`: a random colour of the cell | | `"distance"` |
//! | `scale` | number above 0 | cells per unit of the coordinates | 1 |
//! | `seed` | whole number: another seed has other points | | 0 |
//!
//! ```toml
//! [texture.cobbles]
//! voronoi = { a = 0.1, b = [0.5, 0.45, 0.4], value = "edge", scale = 6 }
//! mapping = "object"
//! ```
//!
//! A distance of 1 is that between neighbouring cells; more than 1 counts as 1. On average `distance` is 0.52 in
//! space (0.43 on s and t), `edge` is 0.197 (0.269) and 0 at the borders of cells, and each channel of `cell` lies
//! anywhere between those of `a` and `b`.
//!
//! With the mappings `object` and `world` the cells fill space, with others they lie on s and t. Cells that are smaller than what a
//! ray sees of the surface fade to the mean.
//!
//! # Implementation
//!
//! There is one point in each cell of a lattice, see `cellular`.

use serde::Deserialize;

use super::{
    FindSources, Lookup, PatternKind, Textures,
    band_limit::contrast,
    cellular::{self, Nearest},
    lookup::Place,
    two_colors::TwoColors,
};
use crate::{
    math::{Rgb, Vec2},
    value::{Count, Positive, Problem, RgbFactor},
};

/// The value of a place among cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CellValue {
    #[default]
    Distance,
    Edge,
    Cell,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VoronoiDesc {
    #[serde(default = "RgbFactor::black")]
    pub a: RgbFactor,
    #[serde(default = "RgbFactor::white")]
    pub b: RgbFactor,
    #[serde(default)]
    pub value: CellValue,
    #[serde(default = "Positive::one")]
    pub scale: Positive,
    pub seed: Option<Count>,
}

impl VoronoiDesc {
    pub fn compile(&self, _find: &FindSources<'_>) -> Result<Voronoi, Problem> {
        Ok(Voronoi {
            colors: TwoColors([self.a.0, self.b.0]),
            value: self.value,
            scale: self.scale.0,
            seed: self.seed.map_or(0, |s| s.0),
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Voronoi {
    pub colors: TwoColors,
    pub value: CellValue,
    pub scale: f32,
    pub seed: u32,
}

/// The mean of a value, the rate at which it loses contrast, see [`contrast`], and its standard deviation.
type Statistics = (f32, f32, f32);

/// The statistics of each value on s and t.
const IN_PLANE: [Statistics; 3] = [(0.429_7, 0.54, 0.190), (0.269_4, 1.15, 0.201), (0.5, 0.35, 0.289)];
/// The statistics of each value in space.
const IN_SPACE: [Statistics; 3] = [(0.520_4, 0.4, 0.172), (0.196_6, 1.0, 0.158), (0.5, 0.35, 0.289)];

impl Voronoi {
    fn statistics(&self, place: Place) -> Statistics {
        let all = match place {
            Place::Plane(_) => &IN_PLANE,
            Place::Space(_) => &IN_SPACE,
        };
        all[self.value as usize]
    }

    /// The value at a place, for each channel from 0 to 1, over a footprint of this width and length.
    fn value(&self, place: Place, widths: [f32; 2]) -> Rgb {
        let (mean, falloff, _) = self.statistics(place);
        let seen = contrast(widths.map(|w| w * self.scale), falloff);
        let Some(place) = place.scaled(self.scale).filter(|_| seen > 0.0) else {
            return Rgb::gray(mean);
        };
        let Nearest { distances, hash } = match place {
            Place::Plane(p) => cellular::nearest(p.to_array(), self.seed),
            Place::Space(p) => cellular::nearest(p.to_array(), self.seed),
        };
        let value = match self.value {
            CellValue::Distance => Rgb::gray(distances[0].min(1.0)),
            CellValue::Edge => Rgb::gray((distances[1] - distances[0]).min(1.0)),
            CellValue::Cell => Rgb::from_array(cellular::color(hash)),
        };
        Rgb::gray(mean) + (value - Rgb::gray(mean)) * seen
    }
}

impl PatternKind for Voronoi {
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        self.colors.at(self.value(lookup.place(), lookup.widths()))
    }

    fn moments(&self, lookup: &Lookup<'_>) -> (Rgb, f32) {
        let (_, falloff, deviation) = self.statistics(lookup.place());
        let seen = contrast(lookup.widths().map(|w| w * self.scale), falloff);
        let spread = self.colors.contrast() * deviation * (1.0 - seen * seen).clamp(0.0, 1.0).sqrt();
        (self.numbers(lookup), spread)
    }

    fn max_value(&self, _textures: &Textures<'_>) -> Rgb {
        self.colors.max()
    }

    fn is_band_limited(&self) -> bool {
        true
    }

    fn steps(&self, _textures: &Textures<'_>) -> Vec2 {
        Vec2::splat(self.scale * STEPS)
    }
}

/// Steps per cell over which a slope is measured.
const STEPS: f32 = 32.0;
