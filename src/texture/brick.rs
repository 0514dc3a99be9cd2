//! Bricks or tiles in mortar.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `a`, `b` | number or `[r, g, b]`, scene-linear: each brick has a colour between these two, at random | | required |
//! | `mortar` | number or `[r, g, b]`, scene-linear: the colour between the bricks | | required |
//! | `size` | `[s, t]`: the length and the height of a brick with its mortar, above 0 | units of s and t | `[0.25, 0.0625]` |
//! | `gap` | number of at least 0: the width of the mortar | units of s and t | 0.01 |
//! | `shift` | number from 0 to 1: how far each second row is moved, in bricks | | 0.5 |
//! | `seed` | whole number: another seed mixes the colours differently | | 0 |
//!
//! ```toml
//! [texture.wall]
//! brick = { a = [0.55, 0.2, 0.12], b = [0.4, 0.12, 0.08], mortar = [0.7, 0.68, 0.62], size = [0.25, 0.075], gap = 0.012 }
//! mapping = "object"
//! ```
//!
//! The first brick of the first row begins at (0, 0), in the middle of the mortar. With a mapping to three coordinates, the first
//! two are s and t. Bricks and mortar are averaged over what a ray sees of the surface: from afar it has their mean colour by area.

use serde::Deserialize;

use super::{FindSources, Lookup, PatternKind, Textures, band_limit::contrast, lattice, source::finite};
use crate::{
    math::{DVec2, Rgb, Vec2, hash},
    value::{Count, List, NonNegative, Positive, Problem, RgbFactor, Spanned, UnitInterval},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BrickDesc {
    pub a: RgbFactor,
    pub b: RgbFactor,
    pub mortar: RgbFactor,
    pub size: Option<List<Positive, 2>>,
    pub gap: Option<Spanned<NonNegative>>,
    pub shift: Option<UnitInterval>,
    pub seed: Option<Count>,
}

impl BrickDesc {
    pub fn compile(&self, _find: &FindSources<'_>) -> Result<Brick, Problem> {
        let size = self.size.map_or([0.25, 0.0625], |size| size.0.map(f32::from));
        let gap = self.gap.as_ref().map_or(0.01, |gap| gap.get_ref().0);
        if let Some(given) = &self.gap
            && size.iter().any(|side| gap > *side)
        {
            return Err(Problem::at(given.span(), "the mortar is wider than a brick"));
        }
        Ok(Brick {
            colors: [self.a.0, self.b.0],
            mortar: self.mortar.0,
            size,
            gap,
            shift: self.shift.map_or(0.5, |shift| shift.0),
            seed: self.seed.map_or(0, |seed| seed.0),
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Brick {
    /// The two colours between which those of bricks are.
    pub colors: [Rgb; 2],
    pub mortar: Rgb,
    /// The sides of a brick with its mortar, in units of s and t.
    pub size: [f32; 2],
    /// The width of the mortar.
    pub gap: f32,
    /// The offset of odd rows, in bricks.
    pub shift: f32,
    pub seed: u32,
}

/// A row of bricks of the length 1, or a pile of rows: those parts of an interval that are on bricks.
struct Parts {
    /// On the brick that the middle of the interval is in.
    own: f32,
    /// On any brick.
    all: f32,
}

impl Parts {
    /// The parts within an interval of this width around `x`, from 0 to 1 in its own brick; each brick has
    /// mortar of half of `gap` at both ends.
    fn of(x: f32, width: f32, gap: f32) -> Self {
        let [from, to] = [0.5 * gap, 1.0 - 0.5 * gap];
        if !width.is_finite() {
            return Self {
                own: 0.0,
                all: to - from,
            };
        }
        if width < NARROW {
            let is_brick = f32::from(x >= from && x < to);
            return Self {
                own: is_brick,
                all: is_brick,
            };
        }
        // The length of bricks between 0 and a place.
        let bricks = |x: f32| {
            let whole = x.floor();
            whole * (to - from) + (x - whole).clamp(from, to) - from
        };
        let [low, high] = [x - 0.5 * width, x + 0.5 * width];
        let own = (high.min(to) - low.max(from)).max(0.0);
        Self {
            own: own / width,
            all: (bricks(high) - bricks(low)) / width,
        }
    }
}

impl Brick {
    /// The colour at a point over an interval of these widths along s and t.
    fn color(&self, st: DVec2, widths: Vec2) -> Rgb {
        let [length, height] = self.size.map(f64::from);
        let y = st.y / height;
        let (row, in_row) = lattice::cell(y);
        let shift = f64::from(self.shift) * f64::from(row & 1);
        let (column, in_brick) = lattice::cell(st.x / length - shift);
        let part = |k: usize, x: f32| Parts::of(x, widths[k] / self.size[k], self.gap / self.size[k]);
        let (along, up) = (part(0, in_brick), part(1, in_row));
        let [a, b] = self.colors;
        let number = hash::unit_f32(lattice::hash([column, row], self.seed));
        let (own, all) = (along.own * up.own, along.all * up.all);
        let others = (all - own).max(0.0);
        (a + (b - a) * number) * own + (a + b) * (0.5 * others) + self.mortar * (1.0 - all)
    }
}

impl PatternKind for Brick {
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        let place = lookup.place();
        if place.scaled(1.0 / self.size[0].min(self.size[1])).is_none() {
            return self.mortar;
        }
        let [a, b] = lookup.axes();
        let square = a * a + b * b;
        finite(self.color(place.st(), Vec2::new(square.x.sqrt(), square.y.sqrt())))
    }

    fn moments(&self, lookup: &Lookup<'_>) -> (Rgb, f32) {
        let bricks = (1.0 - self.gap / self.size[0]) * (1.0 - self.gap / self.size[1]);
        let [a, b] = self.colors;
        let difference = ((a + b) * 0.5 - self.mortar).map(f32::abs).mean();
        let [_, long] = lookup.widths();
        let seen = contrast([long / self.size[1]; 2], 1.0);
        let variance = bricks * (1.0 - bricks) * (1.0 - seen * seen).clamp(0.0, 1.0);
        (self.numbers(lookup), difference * variance.sqrt())
    }

    fn max_value(&self, _textures: &Textures<'_>) -> Rgb {
        let [a, b] = self.colors;
        a.max(b).max(self.mortar)
    }

    fn is_band_limited(&self) -> bool {
        true
    }

    fn steps(&self, _textures: &Textures<'_>) -> Vec2 {
        Vec2::from_array(self.size.map(|side| STEPS / side))
    }
}

/// A part of a brick that is too short for the difference of two places to tell its length.
const NARROW: f32 = 1.0 / (1_u32 << 20) as f32;

/// Steps per brick over which a slope is measured.
const STEPS: f32 = 64.0;
