//! The sheen of cloth.

use std::sync::OnceLock;

use super::{
    integral::direction,
    table::{along, column, lerp, locate, node},
};
use crate::{
    bsdf::sheen::{self, MIN_ROUGHNESS},
    math::{Vec3, trig},
};

const ROWS: usize = 32;
const COLUMNS: usize = 64;
/// Points of an integral, by tilt and by turn.
const STEPS: [usize; 2] = [32, 24];
/// A margin that keeps all values above the exact albedo, where that is below 1; above, a fraction of
/// it.
const MARGIN: f32 = 0.002;

static TABLE: [OnceLock<Box<[f32; COLUMNS]>>; ROWS] = [const { OnceLock::new() }; ROWS];

fn row(i: usize) -> &'static [f32; COLUMNS] {
    TABLE[i].get_or_init(|| {
        let roughness = MIN_ROUGHNESS + (1.0 - MIN_ROUGHNESS) * node(i, ROWS);
        Box::new(std::array::from_fn(|j| {
            let root: f32 = node(j, COLUMNS);
            integral(roughness, direction(root * root))
        }))
    })
}

fn integral(roughness: f32, wo: Vec3) -> f32 {
    let [tilts, turns] = STEPS;
    let mut sum = 0.0_f64;
    for k in 0..tilts {
        // Denser towards the rim, where sheen is.
        let q = (k as f32 + 0.5) / tilts as f32;
        let z = q * q;
        let sin = (1.0 - z * z).sqrt();
        for l in 0..turns {
            let (s, c) = trig::sin_cos(std::f32::consts::PI * (l as f32 + 0.5) / turns as f32);
            let wi = Vec3::new(sin * c, sin * s, z);
            sum += f64::from(sheen::raw_f_cos(roughness, wo, wi) * 2.0 * q);
        }
    }
    (sum * f64::from(std::f32::consts::TAU) / (tilts * turns) as f64) as f32
}

/// The albedo of a white sheen before it is scaled down where it would be above 1.
pub fn raw_sheen(roughness: f32, cos: f32) -> f32 {
    let (i, f) = locate((roughness - MIN_ROUGHNESS) / (1.0 - MIN_ROUGHNESS), ROWS);
    let column = column(cos.abs());
    let table = lerp(along(row(i), column), along(row(i + 1), column), f);
    table + MARGIN * table.max(1.0)
}
