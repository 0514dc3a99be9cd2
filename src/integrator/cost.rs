//! Where a picture's time goes: how many boxes and primitives each camera ray tests.
//!
//! No keys. R holds the nodes (all boxes of a wide node count as one), G the primitives; an EXR has them once more as the
//! channels `cost.nodes` and `cost.primitives`, and a PNG shows their sum as heat (view `heat`).
//!
//! ```toml
//! [render]
//! integrator = "cost"
//! ```

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
