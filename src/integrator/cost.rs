//! A heat map of the cost of tracing: how many boxes and primitives each camera ray tests.
//!
//! No keys.
//!
//! ```toml
//! [render]
//! integrator = "cost"
//! ```
//!
//! R counts the nodes (all boxes of a wide node count as one) and G the primitives. An EXR file also has them as the
//! channels `cost.nodes` and `cost.primitives`; a PNG file shows their sum as a heat map (view `heat`).

use serde::Deserialize;

use super::{Departures, Integrator, Layer, Shown, Visit};
use crate::{accel::RayCost, math::Rgb, value::Problem};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostDesc {}

impl CostDesc {
    pub fn compile(&self) -> Result<Cost, Problem> {
        Ok(Cost)
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Cost;

/// What an EXR says beside R, G and B.
const LAYERS: &[Layer] = &[
    Layer {
        name: "cost.nodes",
        channel: 0,
    },
    Layer {
        name: "cost.primitives",
        channel: 1,
    },
];

impl Integrator for Cost {
    /// Never asked: the wave asks for [`Cost::traversal`] instead.
    fn vertex(&self, _visit: &Visit<'_>, _out: &mut Departures) {}

    fn reads_traversal(&self) -> bool {
        true
    }

    fn traversal(&self, cost: RayCost, out: &mut Departures) {
        out.add(Rgb::new(cost.nodes as f32, cost.prims as f32, 0.0));
    }

    fn shown(&self) -> Shown {
        Shown::Counts
    }

    fn layers(&self) -> &'static [Layer] {
        LAYERS
    }
}
