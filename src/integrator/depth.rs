//! How far away is what the camera sees.
//!
//! No keys. R is the depth along the camera's line of sight, as compositors want it, G the distance along the ray, both in m from
//! the eye. A camera without a line of sight (a panorama) has the distance in both. An EXR has them once more as `depth.Z`
//! and `distance.Y`; a PNG shows R, near white and far black, by the logarithm: 1 m is nine tenths white, every doubling a tenth
//! darker, 1 km black (view `near`; `exposure` of -1 shows 2 m as 1 m). Where nothing is met both are 1e10, and alpha is 0.
//!
//! These are numbers and no light, so every pixel shows what one ray through its centre, and the centre of the lens, meets:
//! `samples` and `filter` have no say.
//!
//! ```toml
//! [render]
//! integrator = "depth"
//! ```

use serde::Deserialize;

use super::{Departures, Integrator, Layer, Shown, Vertex, Visit};
use crate::{math::Rgb, value::Problem};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthDesc {}

impl DepthDesc {
    pub fn compile(&self) -> Result<Depth, Problem> {
        Ok(Depth)
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Depth;

/// How far away nothing is, in m.
const NOTHING: f32 = 1e10;

const LAYERS: &[Layer] = &[
    Layer {
        name: "depth.Z",
        channel: 0,
    },
    Layer {
        name: "distance.Y",
        channel: 1,
    },
];

impl Integrator for Depth {
    fn vertex(&self, visit: &Visit<'_>, out: &mut Departures) {
        let Vertex::Surface(surface, _) = visit.vertex else {
            return out.add(Rgb::new(NOTHING, NOTHING, 0.0));
        };
        let way = visit.ray.d * surface.t;
        let distance = way.length();
        let depth = visit.camera.axis().map_or(distance, |axis| way.dot(axis));
        out.add(Rgb::new(depth, distance, 0.0));
    }

    fn shown(&self) -> Shown {
        Shown::Distance
    }

    fn layers(&self) -> &'static [Layer] {
        LAYERS
    }
}
