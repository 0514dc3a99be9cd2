//! Parallel light from infinitely far away.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `direction` | `[x, y, z]`, where it shines to | | required |
//! | `irradiance` | number or `[r, g, b]`, on a surface that faces it | W m^-2 | required |
//!
//! ```toml
//! [[light]]
//! sun = { direction = [-1, -2, -1], irradiance = [3, 3, 2.8] }
//! ```

use serde::Deserialize;

use super::{LightKind, LightSample};
use crate::{
    math::{Rgb, Vec2, Vec3},
    value::{Direction, Problem, Tint},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SunDesc {
    pub direction: Direction,
    pub irradiance: Tint,
}

impl SunDesc {
    pub fn compile(&self) -> Result<SunLight, Problem> {
        Ok(SunLight {
            direction: self.direction.0,
            irradiance: self.irradiance.0,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct SunLight {
    /// Unit, where it shines to.
    pub direction: Vec3,
    pub irradiance: Rgb,
}

impl LightKind for SunLight {
    #[inline]
    fn sample(&self, _from: Vec3, _u: Vec2) -> Option<LightSample> {
        (!self.irradiance.is_black()).then_some(LightSample {
            wi: -self.direction,
            distance: f32::INFINITY,
            li: self.irradiance,
            pdf: None,
        })
    }
}
