//! A heat map of the cost of tracing: how many boxes and primitives each camera ray tests.
//!
//! No keys.
//!
//! ```toml
//! [render]
//! integrator = "cost"
//! ```
//!
//! The picture is the pass `cost`: EXR files hold the channels `cost.nodes` (all boxes of a wide node count as one) and
//! `cost.primitives`, PNG files show their sum as a colour from dark blue (0) over green (31) to red (1023 and more).

use serde::{Deserialize, Serialize};

use super::{Integrator, ShadingOutput, VertexContext};
use crate::{accel::RayCost, math::Rgb, value::Problem};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostDesc {}

impl CostDesc {
    pub fn compile(&self) -> Result<Cost, Problem> {
        Ok(Cost)
    }
}

#[derive(Clone, Copy, Debug, Serialize)]
pub struct Cost;

impl Integrator for Cost {
    /// Never called: the wave calls [`Cost::add_cost`] instead.
    fn vertex(&self, _context: &VertexContext<'_>, _out: &mut ShadingOutput) {}

    fn wants_cost(&self) -> bool {
        true
    }

    fn add_cost(&self, cost: RayCost, out: &mut ShadingOutput) {
        out.add(Rgb::new(cost.nodes as f32, cost.prims as f32, 0.0));
    }
}
