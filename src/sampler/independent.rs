//! Independent random numbers: a baseline for comparing samplers.
//!
//! No keys.
//!
//! ```toml
//! [render]
//! sampler = "independent"
//! ```
//!
//! Noise is higher than with `sobol`.

use serde::{Deserialize, Serialize};

use super::{Dimension, Filled, SampleKey, SampleKeys, UnitBits};
use crate::{
    math::{
        Dispatch, Vec2,
        hash::{mix32, pcg4d, unit_f32},
    },
    value::Problem,
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IndependentDesc {}

impl IndependentDesc {
    pub fn compile(&self, _samples: u32) -> Result<Independent, Problem> {
        Ok(Independent)
    }
}

/// White noise from a hash of the address.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Independent;

impl Independent {
    /// Returns two random numbers in `[0, 1)`.
    #[inline]
    pub fn get_2d(self, key: &SampleKey, dimension: Dimension) -> Vec2 {
        self.get_3d(key, dimension).0
    }

    /// Returns the same two numbers and a third one.
    #[inline]
    pub fn get_3d(self, key: &SampleKey, dimension: Dimension) -> (Vec2, UnitBits) {
        let picture = mix32(key.seed) ^ (key.frame as u32).wrapping_mul(0x9e37_79b9);
        let [a, b, c, _] = pcg4d([key.pixel[0] ^ mix32(picture), key.pixel[1], key.sample, dimension.0]);
        (Vec2::new(unit_f32(a), unit_f32(b)), UnitBits(c))
    }

    /// Replaces the contents of `numbers` with those of all `keys`.
    pub fn fill(self, _on: impl Dispatch, keys: &SampleKeys, dimension: Dimension, numbers: Filled<'_>) {
        let all = || (0..keys.len()).map(|i| self.get_3d(&keys.get(i), dimension));
        numbers.pairs.clear();
        numbers.pairs.extend(all().map(|(pair, _)| pair));
        if let Some(thirds) = numbers.thirds {
            thirds.clear();
            thirds.extend(all().map(|(_, third)| third));
        }
    }
}
